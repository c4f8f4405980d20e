// EuRoC ASL layout (Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016): mav0/cam{0,1} with data.csv,
// sensor.yaml and data/.
#include <cmath>
#include <cstdlib>

#include "calibration/yaml_document.hpp"
#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "kinetrace/core/se3.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 20.0;

struct TimedImage {
  std::int64_t time_ns = 0;
  std::string stem;
};

Result<fs::path> find_mav(const DatasetSpec& spec) {
  const std::vector<fs::path> candidates{spec.path, spec.path / "mav0", spec.path / spec.sequence / "mav0"};
  for (const fs::path& candidate : candidates) {
    if (is_folder(candidate / "cam0") && is_folder(candidate / "cam1")) {
      return candidate;
    }
  }
  std::vector<std::string> sequences = subfolders(spec.path);
  std::erase_if(sequences, [&spec](const std::string& name) { return !is_folder(spec.path / name / "mav0" / "cam0"); });
  if (!sequences.empty()) {
    return choose_sequence(spec.path, spec.sequence, sequences).transform([&spec](const std::string& name) {
      return spec.path / name / "mav0";
    });
  }
  return fail(ErrorCode::kNotFound,
              spec.path.string() +
                  ": no EuRoC sequence here (looked for cam0 and cam1 in it and in mav0); give the "
                  "folder that holds mav0");
}

// The entries of data.csv with an existing file; the others are missing sides.
Result<std::vector<TimedImage>> read_image_list(const fs::path& camera, const ImageFolder& images) {
  const fs::path path = camera / "data.csv";
  const Result<std::string> text = read_text(path);
  if (!text) {
    return Unexpected(text.error());
  }
  std::vector<std::string> present = images.stems;
  std::sort(present.begin(), present.end());
  std::vector<TimedImage> list;
  for (const std::string_view line : content_lines(*text)) {
    const std::size_t comma = line.find(',');
    const auto time = parse_integer(line.substr(0, comma));
    if (!time || !FrameList::holds_time(*time) || comma == std::string_view::npos) {
      return fail(ErrorCode::kBadFormat, concat(path.string(), ": '", line.substr(0, 60),
                                                "' is no entry; expected 'time in nanoseconds,file name'"));
    }
    if (!list.empty() && *time <= list.back().time_ns) {
      return fail(ErrorCode::kBadFormat, concat(path.string(), ": time ", std::to_string(*time),
                                                " does not come after the one before it; sort the entries"));
    }
    std::string_view name = line.substr(comma + 1);
    name.remove_prefix(std::min(name.find_first_not_of(' '), name.size()));
    std::string stem = fs::path(name).stem().string();
    if (std::binary_search(present.begin(), present.end(), stem)) {
      list.push_back({*time, std::move(stem)});
    }
  }
  return list;
}

std::int64_t distance_ns(const TimedImage& a, const TimedImage& b) {
  return std::abs(a.time_ns - b.time_ns);
}

// Whether images[i] has no partner: the next image of the other side is too late, or nearer to the successor of
// images[i].
bool has_no_partner(const std::vector<TimedImage>& images, std::size_t i, const std::vector<TimedImage>& others,
                    std::size_t other, std::int64_t period_ns) {
  if (i == images.size()) {
    return false;
  }
  if (other == others.size() || images[i].time_ns + period_ns / 2 < others[other].time_ns) {
    return true;
  }
  return i + 1 < images.size() && distance_ns(images[i + 1], others[other]) < distance_ns(images[i], others[other]);
}

// Pairs each left image with the nearest right one within half a period; both lists ascend in time. An image without a
// partner becomes a frame with one side.
std::vector<std::pair<const TimedImage*, const TimedImage*>> matched(const std::vector<TimedImage>& left,
                                                                     const std::vector<TimedImage>& right,
                                                                     std::int64_t period_ns) {
  std::vector<std::pair<const TimedImage*, const TimedImage*>> pairs;
  std::size_t l = 0;
  std::size_t r = 0;
  while (l < left.size() || r < right.size()) {
    if (has_no_partner(left, l, right, r, period_ns)) {
      pairs.emplace_back(&left[l++], nullptr);
    } else if (has_no_partner(right, r, left, l, period_ns)) {
      pairs.emplace_back(nullptr, &right[r++]);
    } else {
      pairs.emplace_back(&left[l++], &right[r++]);
    }
  }
  return pairs;
}

Status add_frames(const std::vector<TimedImage>& left, const std::vector<TimedImage>& right, std::int64_t period_ns,
                  FrameList& frames) {
  const auto pairs = matched(left, right, period_ns);
  std::vector<std::int64_t> times_ns;
  times_ns.reserve(pairs.size());
  for (const auto& [left_image, right_image] : pairs) {
    times_ns.push_back(left_image != nullptr ? left_image->time_ns : right_image->time_ns);
  }
  const std::vector<std::int64_t> numbers = numbers_from_times(times_ns, period_ns);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [left_image, right_image] = pairs[i];
    Status added = frames.add({numbers[i], times_ns[i], left_image != nullptr ? left_image->stem : std::string_view(),
                               right_image != nullptr ? right_image->stem : std::string_view()});
    if (!added) {
      return added;
    }
  }
  return {};
}

std::int64_t median_period_ns(const std::vector<TimedImage>& images, double fallback_rate_hz) {
  std::vector<std::int64_t> times_ns;
  times_ns.reserve(images.size());
  for (const TimedImage& image : images) {
    times_ns.push_back(image.time_ns);
  }
  return median_step_ns(times_ns, static_cast<std::int64_t>(std::llround(1e9 / fallback_rate_hz)));
}

struct Sensor {
  CameraModel camera;
  Se3 T_body_cam;
};

Result<Sensor> read_sensor(const YamlDocument& file) {
  const auto size = file.numbers("resolution", 2);
  const auto intrinsics = file.numbers("intrinsics", 4);
  const auto coefficients = file.numbers("distortion_coefficients");
  const auto T_body_cam = file.transform("T_BS");
  const auto model = file.text("distortion_model");
  if (const Error* error = first_error(size, intrinsics, coefficients, T_body_cam, model)) {
    return Unexpected(*error);
  }
  Sensor sensor;
  if (*model == "equidistant") {
    sensor.camera.lens = LensModel::kEquidistant;
  } else if (*model != "radial-tangential" && *model != "radtan") {
    return file.error("distortion_model", concat("is '", *model, "'; use radial-tangential or equidistant"));
  }
  const std::size_t most = sensor.camera.lens == LensModel::kEquidistant ? 4 : 5;
  if (coefficients->size() < 4 || coefficients->size() > most) {
    return file.error("distortion_coefficients", concat("must be 4 to ", std::to_string(most), " numbers"));
  }
  std::copy(coefficients->begin(), coefficients->end(), sensor.camera.distortion.begin());
  sensor.camera.width_px = whole_pixels((*size)[0]);
  sensor.camera.height_px = whole_pixels((*size)[1]);
  sensor.camera.fx_px = (*intrinsics)[0];
  sensor.camera.fy_px = (*intrinsics)[1];
  sensor.camera.cx_px = (*intrinsics)[2];
  sensor.camera.cy_px = (*intrinsics)[3];
  sensor.T_body_cam = *T_body_cam;
  return sensor;
}

Result<YamlDocument> load_sensor_file(const fs::path& camera) {
  if (!is_file(camera / "sensor.yaml")) {
    return fail(ErrorCode::kNotFound,
                concat("no calibration: looked for ", (camera / "sensor.yaml").string(), "; copy it there"));
  }
  return YamlDocument::load(camera / "sensor.yaml");
}

Result<double> nominal_rate_hz(const YamlDocument& sensor) {
  if (!sensor.has("rate_hz")) {
    return kRate_hz;
  }
  const auto rate = sensor.numbers("rate_hz", 1);
  if (!rate) {
    return Unexpected(rate.error());
  }
  if (rate->front() <= 0) {
    return sensor.error("rate_hz", "must be positive, got " + number(rate->front()));
  }
  return rate->front();
}

Result<RigCalibration> read_rig(const YamlDocument& left_file, const YamlDocument& right_file) {
  const auto left = read_sensor(left_file);
  const auto right = read_sensor(right_file);
  if (const Error* error = first_error(left, right)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  rig.source = concat(left_file.path().string(), ", ", right_file.path().string());
  rig.left = left->camera;
  rig.right = right->camera;
  rig.T_right_left = right->T_body_cam.inverse() * left->T_body_cam;
  return rig;
}

}  // namespace

Result<Dataset> open_euroc(const DatasetSpec& spec) {
  const Result<fs::path> mav = find_mav(spec);
  if (!mav) {
    return Unexpected(mav.error());
  }
  const auto left_sensor = load_sensor_file(*mav / "cam0");
  const auto right_sensor = load_sensor_file(*mav / "cam1");
  const auto left_images = list_images(*mav / "cam0" / "data");
  const auto right_images = list_images(*mav / "cam1" / "data");
  if (const Error* error = first_error(left_sensor, right_sensor, left_images, right_images)) {
    return Unexpected(*error);
  }
  const auto left = read_image_list(*mav / "cam0", *left_images);
  const auto right = read_image_list(*mav / "cam1", *right_images);
  const auto rate_hz = nominal_rate_hz(*left_sensor);
  if (const Error* error = first_error(left, right, rate_hz)) {
    return Unexpected(*error);
  }
  Dataset dataset;
  const fs::path absolute = fs::weakly_canonical(*mav);
  dataset.name = (absolute.filename() == "mav0" ? absolute.parent_path() : absolute).filename().string();
  dataset.max_file_bytes = std::max(left_images->max_file_bytes, right_images->max_file_bytes);
  dataset.frames = FrameList(left_images->files, right_images->files, (*mav / "cam0" / "data.csv").string());
  if (const Status added = add_frames(*left, *right, median_period_ns(*left, *rate_hz), dataset.frames); !added) {
    return Unexpected(added.error());
  }
  return finish_dataset(std::move(dataset), *rate_hz,
                        [&](const ImageSize&) { return read_rig(*left_sensor, *right_sensor); });
}

}  // namespace kinetrace::hal
