// Cityscapes (Cordts et al., CVPR 2016): leftImg8bit[_sequence]/SPLIT/CITY/CITY_SEQ_FRAME_leftImg8bit.png, the same on
// the right, camera/SPLIT/CITY/CITY_SEQ_FRAME_camera.json. Images are rectified.
#include <array>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kRate_hz = 17.0;
constexpr std::string_view kLeftTag = "_leftImg8bit";
constexpr std::string_view kRightTag = "_rightImg8bit";

// A city of one split, e.g. {"leftImg8bit_sequence", "_sequence", "val", "frankfurt"}.
struct City {
  std::string kind;  // Ending of the image folders: "" or "_sequence".
  std::string split;
  std::string name;
};

std::vector<City> cities(const fs::path& root) {
  std::vector<City> found;
  for (const char* kind : {"_sequence", ""}) {
    const fs::path images = root / (std::string("leftImg8bit") + kind);
    for (const std::string& split : subfolders(images)) {
      for (const std::string& name : subfolders(images / split)) {
        found.push_back({kind, split, name});
      }
    }
    if (!found.empty()) {
      break;
    }
  }
  return found;
}

std::string city_of(std::string_view sequence) {
  return std::string(sequence.substr(0, sequence.find('_')));
}

Result<City> choose_city(const DatasetSpec& spec) {
  std::vector<City> all = cities(spec.path);
  if (all.empty()) {
    return fail(ErrorCode::kNotFound, spec.path.string() +
                                          ": no Cityscapes images here (looked for leftImg8bit_sequence/SPLIT/CITY and "
                                          "leftImg8bit/SPLIT/CITY); give the folder that holds leftImg8bit");
  }
  std::vector<std::string> names;
  names.reserve(all.size());
  for (const City& city : all) {
    names.push_back(city.name);
  }
  const auto name = choose_sequence(spec.path, city_of(spec.sequence), names);
  if (!name) {
    return Unexpected(name.error());
  }
  return *std::find_if(all.begin(), all.end(), [&name](const City& city) { return city.name == *name; });
}

// "CITY_SEQ" of the recording: the requested one, or the only one of the city.
Result<std::string> choose_recording(const fs::path& folder, const std::string& wanted, const ImageFolder& images) {
  std::set<std::string> recordings;
  for (const std::string& stem : images.stems) {
    recordings.insert(stem.substr(0, stem.rfind('_')));
  }
  const bool whole_city = wanted.find('_') == std::string::npos;
  return choose_sequence(folder, whole_city ? std::string() : wanted,
                         std::vector<std::string>(recordings.begin(), recordings.end()));
}

// The camera file of any frame of the recording: the rig does not change within one.
Result<fs::path> find_camera_file(const fs::path& root, const City& city, const std::string& recording) {
  constexpr std::array<const char*, 3> kFolders{"camera", "camera_sequence", "camera_trainvaltest/camera"};
  for (const char* folder : kFolders) {
    const fs::path cameras = root / folder / city.split / city.name;
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator entry(cameras, error), end; !error && entry != end; entry.increment(error)) {
      const std::string name = entry->path().filename().string();
      if (name.starts_with(recording + "_") && name.ends_with("_camera.json")) {
        files.push_back(entry->path());
      }
    }
    if (!files.empty()) {
      return *std::min_element(files.begin(), files.end());
    }
  }
  return fail(
      ErrorCode::kNotFound,
      concat("no calibration: looked for ", (root / "camera" / city.split / city.name).string(), "/", recording,
             "_*_camera.json, also in camera_sequence and camera_trainvaltest/camera; unpack the camera archive "
             "there"));
}

Result<double> json_number(const Json& json, const char* group, const char* key, const fs::path& path) {
  const auto found_group = json.find(group);
  if (found_group != json.end() && found_group->is_object()) {
    const auto value = found_group->find(key);
    if (value != found_group->end() && value->is_number()) {
      return value->get<double>();
    }
  }
  return fail(ErrorCode::kBadCalibration, concat(path.string(), ": '", group, ".", key, "' is missing or no number"));
}

Result<RigCalibration> read_camera_file(const fs::path& path, const ImageSize& size) {
  const Result<std::string> text = read_text(path, kMaxCalibrationBytes);
  if (!text) {
    return Unexpected(text.error());
  }
  const Json json = Json::parse(*text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    return fail(ErrorCode::kBadCalibration, path.string() + ": is no valid JSON object; unpack it again");
  }
  const auto fx = json_number(json, "intrinsic", "fx", path);
  const auto fy = json_number(json, "intrinsic", "fy", path);
  const auto cx = json_number(json, "intrinsic", "u0", path);
  const auto cy = json_number(json, "intrinsic", "v0", path);
  const auto baseline = json_number(json, "extrinsic", "baseline", path);
  if (const Error* error = first_error(fx, fy, cx, cy, baseline)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  rig.source = path.string();
  rig.rectified = StereoGeometry{.fx_px = *fx,
                                 .fy_px = *fy,
                                 .cx_px = *cx,
                                 .cy_px = *cy,
                                 .baseline_m = *baseline,
                                 .width_px = size.width_px,
                                 .height_px = size.height_px};
  return rig;
}

}  // namespace

Result<Dataset> open_cityscapes(const DatasetSpec& spec) {
  if (spec.cameras == CameraChoice::kGray) {
    return fail(ErrorCode::kInvalidArgument,
                spec.path.string() + ": Cityscapes has colour cameras only; choose color or auto");
  }
  const auto city = choose_city(spec);
  if (!city) {
    return Unexpected(city.error());
  }
  const fs::path left_folder = spec.path / ("leftImg8bit" + city->kind) / city->split / city->name;
  const fs::path right_folder = spec.path / ("rightImg8bit" + city->kind) / city->split / city->name;
  const auto all = list_images(left_folder, "", kLeftTag);
  if (!all) {
    return Unexpected(all.error());
  }
  const auto recording = choose_recording(left_folder, spec.sequence, *all);
  if (!recording) {
    return Unexpected(recording.error());
  }
  const auto camera_file = find_camera_file(spec.path, *city, *recording);
  auto left = list_images(left_folder, *recording + "_", kLeftTag);
  auto right = list_images(right_folder, *recording + "_", kRightTag);
  if (const Error* error = first_error(camera_file, left, right)) {
    return Unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), {}, kRate_hz};
  return build_dataset(*recording, files, spec,
                       [&camera_file](const ImageSize& size) { return read_camera_file(*camera_file, size); });
}

}  // namespace kinetrace::hal
