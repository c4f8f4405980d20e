#include "camera/camera_config.hpp"

#include <array>
#include <utility>

#include "config/config_file.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/hal/fault_injector.hpp"

namespace kinetrace::app {
namespace {

constexpr std::array<std::pair<CameraKind, std::string_view>, 3> kKinds{
    {{CameraKind::kV4l2, "v4l2"}, {CameraKind::kLibcamera, "libcamera"}, {CameraKind::kFiles, "files"}}};

// An unused number is refused: its author assumes that it has an effect.
Status check_settings(const CameraConfig& config) {
  struct Setting {
    const char* name;
    const char* automatic;
    bool is_automatic;
    double value;
  };
  for (const Setting& setting :
       {Setting{"image.exposure_us", "image.auto_exposure", config.auto_exposure, config.exposure_us},
        Setting{"image.gain", "image.auto_gain", config.auto_gain, config.gain}}) {
    const bool is_given = setting.value != CameraConfig::kNotGiven;
    if (setting.is_automatic == is_given) {
      return fail(ErrorCode::kInvalidConfig, std::string(setting.name) + (is_given ? " needs " : " is missing with ") +
                                                 setting.automatic + ": false");
    }
  }
  return {};
}

Status check(const CameraConfig& config, bool needs_calibration) {
  constexpr int kMaxLoop = 1'000'000;
  if (!config.faults.empty()) {
    if (const auto faults = hal::parse_faults(config.faults); !faults) {
      return fail(ErrorCode::kInvalidConfig, "faults: " + faults.error().message);
    }
  }
  if (config.source == CameraKind::kFiles) {
    const Result<hal::DatasetSpec> dataset = config.dataset();
    return dataset ? check_range("files.loop", config.loop, 1, kMaxLoop) : Unexpected(dataset.error());
  }
  if (config.calibration.empty() && needs_calibration) {
    return fail(ErrorCode::kInvalidConfig,
                "calibration is missing; name the file with the rig's calibration (`kinetrace calibrate` makes one)");
  }
  return first_failure({check_settings(config), config.live().validate()});
}

}  // namespace

std::string_view to_string(CameraKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)].second;
}

bool from_string(std::string_view text, CameraKind& kind) noexcept {
  for (const auto& [known, name] : kKinds) {
    if (name == text) {
      kind = known;
      return true;
    }
  }
  return false;
}

hal::LiveCameraConfig CameraConfig::live() const {
  hal::LiveCameraConfig live = timeouts;
  live.left = image;
  live.left.backend = source == CameraKind::kLibcamera ? hal::CaptureBackend::kLibcamera : hal::CaptureBackend::kV4l2;
  live.left.exposure_us = auto_exposure ? std::nullopt : std::optional(exposure_us);
  live.left.gain = auto_gain ? std::nullopt : std::optional(gain);
  live.left.device = left_device;
  live.right.reset();
  if (!right_device.empty()) {
    live.right = live.left;
    live.right->device = right_device;
  }
  return live;
}

Result<hal::DatasetSpec> CameraConfig::dataset() const {
  const auto known = hal::parse_layout(layout);
  if (!known) {
    return fail(ErrorCode::kInvalidConfig, "files.layout: " + known.error().message);
  }
  if (path.empty()) {
    return fail(ErrorCode::kInvalidConfig, "files.path is missing; name the recording's folder");
  }
  return hal::DatasetSpec{.layout = *known, .path = path, .sequence = sequence};
}

Result<CameraConfig> load_camera_config(const std::filesystem::path& path, bool needs_calibration) {
  CameraConfig config;
  const ConfigFileKind kind{
      .missing = "no such camera file; give one that says which devices, such as those in config/cameras",
      .unfit = "not a camera file (a YAML text below 1 MiB)",
      .empty = "is empty; copy the one of config/cameras that is most like your rig",
      .key_list = "the files in config/cameras show the keys"};
  if (const Status read = read_config_file(path, fields_of(config), kind); !read) {
    return Unexpected(read.error());
  }
  resolve_paths(path, std::array{&config.calibration, &config.path});
  if (const Status valid = check(config, needs_calibration); !valid) {
    return fail(valid.error().code, path.string() + ": " + valid.error().message);
  }
  return config;
}

}  // namespace kinetrace::app
