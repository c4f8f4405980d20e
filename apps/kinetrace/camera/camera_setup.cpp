#include "camera/camera_setup.hpp"

#include "camera/libcamera_loader.hpp"

namespace kinetrace::app {
namespace {

// Parts of the camera each begin at a multiple of the arena's alignment.
std::size_t aligned(std::size_t bytes) {
  return (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
}

int view_width_px(const hal::LiveCameraConfig& live) {
  return live.right ? live.left.width_px : live.left.width_px / 2;
}

Outcome<hal::DatasetSpec> dataset_spec(const SourceOptions& options) {
  const std::size_t colon = options.dataset.find(':');
  if (colon == std::string::npos || colon + 1 == options.dataset.size()) {
    return Unexpected(Failure{
        ExitCode::kUsage, "--dataset " + options.dataset + ": expected LAYOUT:PATH, for example kitti-raw:data/drive"});
  }
  const auto layout = hal::parse_layout(options.dataset.substr(0, colon));
  if (!layout) {
    return failure(layout.error());
  }
  hal::DatasetSpec spec;
  spec.layout = *layout;
  spec.path = options.dataset.substr(colon + 1);
  spec.sequence = options.sequence;
  spec.uncalibrated = options.uncalibrated;
  if (!options.cameras.empty()) {
    spec.cameras = options.cameras == "gray" ? hal::CameraChoice::kGray : hal::CameraChoice::kColor;
  }
  return spec;
}

// LAYOUT:PATH for run.json, with an absolute path: valid from any working directory.
std::string source_text(const std::string& layout, const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error).lexically_normal();
  return layout + ":" + (error ? path : absolute).string();
}

// Minimum size for feature extraction; checked here, where the error can name the recording.
Status check_size(const hal::Dataset& dataset, const hal::DatasetSpec& spec) {
  constexpr int kMinWidth_px = 64;
  constexpr int kMinHeight_px = 48;
  const int width_px = dataset.calibration.raw_width_px();
  const int height_px = dataset.calibration.raw_height_px();
  if (width_px < kMinWidth_px || height_px < kMinHeight_px) {
    return fail(ErrorCode::kBadFormat, spec.path.string() + ": its images of " + std::to_string(width_px) + "x" +
                                           std::to_string(height_px) + " pixels are too small; at least " +
                                           std::to_string(kMinWidth_px) + "x" + std::to_string(kMinHeight_px) +
                                           " are needed");
  }
  return {};
}

Outcome<CameraSetup> recorded(const hal::DatasetSpec& spec) {
  const Result<hal::Dataset> dataset = hal::open_dataset(spec);
  if (!dataset) {
    return failure(dataset.error());
  }
  if (const Status size = check_size(*dataset, spec); !size) {
    return failure(size.error());
  }
  CameraSetup setup = recording_setup(*dataset);
  setup.folder = spec.path;
  return setup;
}

/// To look up a frame's images, readers must know whether frame numbers continue beyond the recording's last.
void describe_passes(CameraSetup& setup) {
  if (setup.passes > 1) {
    setup.description.emplace_back("passes", std::to_string(setup.passes));
  }
}

Outcome<CameraSetup> from_dataset(const SourceOptions& options) {
  const Outcome<hal::DatasetSpec> spec = dataset_spec(options);
  if (!spec) {
    return Unexpected(spec.error());
  }
  Outcome<CameraSetup> setup = recorded(*spec);
  if (setup) {
    setup->passes = options.passes;
    setup->images = "recording " + options.dataset;
    setup->description = {{"dataset", source_text(options.dataset.substr(0, options.dataset.find(':')), spec->path)},
                          {"sequence", setup->dataset->name},
                          {"calibration", setup->calibration.source},
                          {"cameras", options.cameras.empty() ? "auto" : options.cameras}};
    describe_passes(*setup);
  }
  return setup;
}

Outcome<CameraSetup> from_files(const CameraConfig& config, bool uncalibrated) {
  Result<hal::DatasetSpec> spec = config.dataset();
  if (!spec) {
    return failure(spec.error());
  }
  spec->uncalibrated = uncalibrated;
  Outcome<CameraSetup> setup = recorded(*spec);
  if (setup) {
    setup->passes = config.loop;
    setup->description = {{"dataset", source_text(config.layout, spec->path)}, {"sequence", setup->dataset->name}};
    describe_passes(*setup);
  }
  return setup;
}

Outcome<CameraSetup> from_devices(const CameraConfig& config, bool uncalibrated) {
  if (config.source == CameraKind::kLibcamera) {
    load_libcamera();
  }
  CameraSetup setup;
  setup.live = config.live();
  const int width_px = view_width_px(*setup.live);
  const int height_px = setup.live->left.height_px;
  auto calibration = uncalibrated ? hal::images_alone(width_px, height_px)
                                  : hal::read_rig_calibration(config.calibration, width_px, height_px);
  if (!calibration) {
    const Error& error = calibration.error();
    return failure(error.code == ErrorCode::kNotFound
                       ? Error{error.code, error.message + "; a camera's calibration comes from kinetrace calibrate "
                                                           "(config/README.md, your own camera)"}
                       : error);
  }
  setup.calibration = std::move(*calibration);
  setup.description = {{"devices", setup.live->right ? config.left_device + ", " + config.right_device
                                                     : config.left_device + ", both views"}};
  return setup;
}

// The run's description records injected faults: it must not pass for a run without faults.
void inject(const hal::FaultPlan& plan, const std::string& text, CameraSetup& setup) {
  setup.faults = plan;
  setup.is_camera = true;
  setup.description.emplace_back("faults", text);
}

Outcome<CameraSetup> from_camera_file(const SourceOptions& options) {
  const Result<CameraConfig> config = load_camera_config(options.camera, !options.uncalibrated);
  if (!config) {
    return failure(config.error());
  }
  Outcome<CameraSetup> setup = config->source == CameraKind::kFiles ? from_files(*config, options.uncalibrated)
                                                                    : from_devices(*config, options.uncalibrated);
  if (setup) {
    setup->is_camera = true;
    setup->images = "camera file " + options.camera;
    setup->description.emplace_back("camera", options.camera);
    setup->description.emplace_back("calibration", setup->calibration.source);
    // Faults on the command line replace those of the file.
    if (!config->faults.empty() && options.faults.empty()) {
      inject(hal::parse_faults(config->faults).value(), config->faults, *setup);
    }
  }
  return setup;
}

}  // namespace

CameraSetup recording_setup(const hal::Dataset& dataset) {
  CameraSetup setup;
  setup.calibration = dataset.calibration;
  setup.notes = dataset.notes;
  setup.dataset = dataset;
  return setup;
}

Outcome<CameraSetup> camera_setup(const SourceOptions& options) {
  Outcome<CameraSetup> setup = options.camera.empty() ? from_dataset(options) : from_camera_file(options);
  if (setup && !options.faults.empty()) {
    const auto faults = hal::parse_faults(options.faults);
    if (!faults) {
      return failure(faults.error());
    }
    inject(*faults, options.faults, *setup);
  }
  return setup;
}

std::size_t CameraSetup::required_bytes() const {
  const std::size_t camera = dataset ? hal::FileStereoCamera::required_bytes(*dataset, {.passes = passes})
                                     : hal::LiveStereoCamera::required_bytes(*live);
  const std::size_t injector =
      faults.empty() ? 0 : hal::FaultInjector::required_bytes(calibration.raw_width_px(), calibration.raw_height_px());
  return aligned(camera) + aligned(injector);
}

Result<GuardedCamera> CameraSetup::make(Arena& arena) const {
  GuardedCamera made;
  std::unique_ptr<hal::StereoCamera> camera;
  const auto take = [&camera](auto& result, auto*& seen) {
    auto owned = std::make_unique<std::decay_t<decltype(*result)>>(std::move(*result));
    seen = owned.get();
    camera = std::move(owned);
  };
  if (dataset) {
    auto file = hal::FileStereoCamera::create(*dataset, {.passes = passes}, arena);
    if (!file) {
      return Unexpected(file.error());
    }
    take(file, made.file);
  } else {
    auto devices = hal::LiveStereoCamera::create(*live, arena);
    if (!devices) {
      return Unexpected(devices.error());
    }
    take(devices, made.live);
  }
  if (!faults.empty()) {
    auto faulty = hal::FaultInjector::create(std::move(camera), faults, calibration.raw_width_px(),
                                             calibration.raw_height_px(), arena);
    if (!faulty) {
      return Unexpected(faulty.error());
    }
    camera = std::move(*faulty);
  }
  // A recording's times are not repaired unless faults were injected.
  const bool repair_timestamps = repairs_timestamps && (live.has_value() || !faults.empty());
  made.camera =
      std::make_unique<hal::FrameGuard>(std::move(camera), hal::FrameGuardConfig{.mend_times = repair_timestamps});
  return made;
}

}  // namespace kinetrace::app
