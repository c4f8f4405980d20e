#include <algorithm>
#include <cstdio>

#include "kinetrace/core/files.hpp"
#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "truth_files.hpp"

namespace kinetrace::evaluation {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

/// A file or folder of known format.
struct Place {
  TruthFormat format = TruthFormat::kSimulator;
  fs::path path;  ///< The folder of kSimulator, else the file.
};

// By the first row, in which the formats differ enough.
std::optional<TruthFormat> format_of_file(const fs::path& path) {
  constexpr std::size_t kKittiPoseFields = 12;
  constexpr std::size_t kLabelFields = 17;
  for (const auto separator : {TextRows::Separator::kBlanks, TextRows::Separator::kComma}) {
    Result<TextRows> rows = TextRows::open(path, separator);
    if (!rows || !rows->next()) {
      return std::nullopt;
    }
    const auto all_numbers = [&](std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        if (!parse_number(rows->text(i))) {
          return false;
        }
      }
      return true;
    };
    const std::size_t fields = rows->size();
    if (separator == TextRows::Separator::kComma) {
      return fields >= 8 && all_numbers(8) ? std::optional(TruthFormat::kEuroc) : std::nullopt;
    }
    if (fields == 8 && all_numbers(8)) {
      return TruthFormat::kTum;
    }
    if (fields == kKittiPoseFields && all_numbers(kKittiPoseFields)) {
      return TruthFormat::kKittiPoses;
    }
    if (fields >= kLabelFields && !parse_number(rows->text(2))) {
      return TruthFormat::kKittiTracking;
    }
  }
  return std::nullopt;
}

bool is_simulator_folder(const fs::path& folder) {
  return is_file(folder / "camera_poses.txt") && is_file(folder / "objects.csv");
}

Result<Place> find_truth(const TruthSource& source) {
  const fs::path& path = source.path;
  if (is_folder(path)) {
    for (const fs::path& folder : {path, path / "truth"}) {
      if (source.format.value_or(TruthFormat::kSimulator) == TruthFormat::kSimulator && is_simulator_folder(folder)) {
        return Place{TruthFormat::kSimulator, folder};
      }
    }
    const fs::path euroc = fs::path("state_groundtruth_estimate0") / "data.csv";
    for (const fs::path& file : {path / "mav0" / euroc, path / euroc, path / "data.csv"}) {
      if (source.format.value_or(TruthFormat::kEuroc) == TruthFormat::kEuroc && is_file(file)) {
        return Place{TruthFormat::kEuroc, file};
      }
    }
    return fail(ErrorCode::kUnsupported, path.string() +
                                             ": holds neither a simulator's truth nor EuRoC's; name the file of poses "
                                             "or labels");
  }
  if (const Result<InputFile> usable = InputFile::open(path.c_str()); !usable) {
    return Unexpected(usable.error());
  }
  const std::optional<TruthFormat> format = source.format ? source.format : format_of_file(path);
  if (!format || *format == TruthFormat::kSimulator) {
    return fail(ErrorCode::kUnsupported,
                path.string() +
                    ": is no truth of a known format; formats are the simulator's folder, KITTI tracking "
                    "labels, and poses of KITTI, TUM or EuRoC");
  }
  return Place{*format, path};
}

Result<TrueCamera> read_camera(const Place& place, const TruthSource& source) {
  switch (place.format) {
    case TruthFormat::kSimulator: return read_kitti_poses(place.path / "camera_poses.txt");
    case TruthFormat::kKittiPoses: return read_kitti_poses(place.path);
    case TruthFormat::kTum: return read_tum(place.path);
    case TruthFormat::kEuroc:
      if (!source.T_body_cam) {
        return fail(ErrorCode::kInvalidArgument, place.path.string() +
                                                     ": has poses of the body; the left camera's sensor.yaml is needed "
                                                     "as well (evaluate --truth-body-camera SENSOR.yaml)");
      }
      return read_euroc(place.path, *source.T_body_cam);
    case TruthFormat::kKittiTracking: break;
  }
  if (source.camera.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                place.path.string() + ": labels are in the camera's frame; a file of camera poses is needed as well");
  }
  TruthSource camera_source = source;
  camera_source.path = source.camera;
  camera_source.format.reset();
  const Result<Place> camera = find_truth(camera_source);
  if (!camera) {
    return Unexpected(camera.error());
  }
  if (camera->format == TruthFormat::kKittiTracking) {
    return fail(ErrorCode::kInvalidArgument, source.camera.string() + ": has labels, not camera poses");
  }
  return read_camera(*camera, source);
}

// The simulator writes one pose for each frame; a missing or extra row would shift all following poses to other frames.
Status check_pose_count(const Place& place, const Truth& truth) {
  const auto poses = static_cast<std::int64_t>(truth.camera.poses.size());
  const std::string has = (place.path / "camera_poses.txt").string() + ": has " + std::to_string(poses) + " rows, ";
  if (!truth.objects.empty() && truth.objects.rbegin()->first >= poses) {
    return fail(ErrorCode::kBadFormat, has + "objects.csv continues until frame " +
                                           std::to_string(truth.objects.rbegin()->first) + "; copy the truth again");
  }
  std::int64_t images = 0;
  std::error_code error;
  for (fs::directory_iterator entry(truth.mask_folder, error), end; !error && entry != end; entry.increment(error)) {
    images += entry->path().extension() == ".png" ? 1 : 0;
  }
  if (images > 0 && images != poses) {
    return fail(ErrorCode::kBadFormat,
                has + truth.mask_folder.string() + " " + std::to_string(images) + " mask images; copy the truth again");
  }
  return {};
}

Status read_objects(const Place& place, const TruthSource& source, Truth& truth) {
  Result<ObjectsByFrame> objects;
  if (place.format == TruthFormat::kSimulator) {
    objects = read_simulator_objects(place.path / "objects.csv");
    truth.is_complete = true;
    if (const fs::path masks = place.path / "masks" / "instances_left"; is_folder(masks)) {
      truth.mask_folder = masks;
    }
  } else if (place.format == TruthFormat::kKittiTracking) {
    objects = read_kitti_labels(place.path, truth.camera, source);
    truth.has_boxes = true;
  } else {
    return {};
  }
  if (!objects) {
    return Unexpected(objects.error());
  }
  truth.objects = std::move(*objects);
  truth.has_objects = true;
  return place.format == TruthFormat::kSimulator ? check_pose_count(place, truth) : Status{};
}

}  // namespace

std::string_view to_string(TruthFormat format) noexcept {
  for (const auto& [name, known] : kTruthFormats) {
    if (known == format) {
      return name;
    }
  }
  return "";
}

Result<Truth> read_truth(const TruthSource& source) {
  const Result<Place> place = find_truth(source);
  if (!place) {
    return Unexpected(place.error());
  }
  Result<TrueCamera> camera = read_camera(*place, source);
  if (!camera) {
    return Unexpected(camera.error());
  }
  Truth truth;
  truth.format = place->format;
  truth.camera = std::move(*camera);
  if (const Status objects = read_objects(*place, source, truth); !objects) {
    return Unexpected(objects.error());
  }
  if (!source.masks.empty()) {
    if (const Status there = check_folder(source.masks, "no such folder of mask images"); !there) {
      return Unexpected(there.error());
    }
    truth.mask_folder = source.masks;
  }
  return truth;
}

std::optional<std::filesystem::path> mask_path(const Truth& truth, std::int64_t frame) {
  for (const int digits : {10, 6}) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%0*lld.png", digits, static_cast<long long>(frame));
    if (fs::path path = truth.mask_folder / name.data(); !truth.mask_folder.empty() && is_file(path)) {
      return path;
    }
  }
  return std::nullopt;
}

}  // namespace kinetrace::evaluation
