// Checks a rig before use in the field.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "camera/camera_loop.hpp"
#include "camera/camera_setup.hpp"
#include "camera/input_watch.hpp"
#include "camera/libcamera_loader.hpp"
#include "camera/rig_report.hpp"
#include "cli/commands.hpp"
#include "cli/formatted.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/option_checks.hpp"
#include "cli/printable.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "dds/doctor_dds.hpp"
#include "dds/run_publishing.hpp"
#include "kinetrace/hal/capture_devices.hpp"
#include "kinetrace/hal/input_monitor.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "plan/board_camera.hpp"
#include "plan/memory.hpp"
#include "plan/network_setup.hpp"
#include "segmentation/doctor_model.hpp"

namespace kinetrace::app {
namespace {

struct DoctorOptions {
  std::string camera;    ///< Camera file; empty: only list the devices.
  std::string publish;   ///< File of a run's --publish.
  double seconds = 2.0;  ///< Duration of the check of the images.
  ConfigSource config;
};

constexpr double kNanosecondsPerMs = 1e6;

/// Prints one line per check and records whether all passed.
class Findings {
 public:
  void ok(const std::string& what, const std::string& detail) {
    std::printf("ok    %-12s %s\n", what.c_str(), printable(detail).c_str());
  }
  void failed(const std::string& what, const std::string& detail) {
    std::printf("FAIL  %-12s %s\n", what.c_str(), printable(detail).c_str());
    all_held_ = false;
  }
  void check(bool holds, const std::string& what, const std::string& detail, const std::string& remedy) {
    holds ? ok(what, detail) : failed(what, detail + "; " + remedy);
  }
  [[nodiscard]] bool all_held() const noexcept { return all_held_; }

 private:
  bool all_held_ = true;
};

void list_devices(Findings& findings) {
  load_libcamera();
  const auto devices = hal::list_capture_devices();
  if (devices.empty()) {
    findings.ok("devices", "none on this machine; a live camera needs one (plug it in, or join the group video)");
  }
  for (const auto& device : devices) {
    if (!device.problem.empty()) {
      findings.failed("device", device.problem);
      continue;
    }
    findings.ok("device", device.name + ", " + device.path + ", " + device.stable_id);
    for (const std::string& mode : device.modes) {
      std::printf("                     %s\n", printable(mode).c_str());
    }
  }
}

/// Measurements of the images.
struct Watched {
  std::int64_t frames = 0;
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::int64_t shortest_ns = 0;
  std::int64_t longest_ns = 0;
  hal::SyncReport pairing;
  std::vector<std::string> faults;  ///< In the images, as lines.
  double residual_sum_px = 0.0;
  RigEstimate rig;  ///< Estimate of the calibration, as far as the camera has moved.

  void add(std::int64_t time_ns) {
    if (frames > 0) {
      const std::int64_t step_ns = time_ns - last_ns;
      shortest_ns = frames == 1 ? step_ns : std::min(shortest_ns, step_ns);
      longest_ns = std::max(longest_ns, step_ns);
    } else {
      first_ns = time_ns;
    }
    last_ns = time_ns;
    ++frames;
  }
  [[nodiscard]] double rate_hz() const {
    return frames > 1 ? 1e9 * static_cast<double>(frames - 1) / static_cast<double>(last_ns - first_ns) : 0.0;
  }
};

// Frequent enough for a check of a few seconds.
constexpr hal::SyncMonitorConfig kMonitor{.interval_frames = 2};

// Estimates only the camera's own motion, which reveals an error that rows do not: the yaw between the views.
pipeline::PipelineConfig only_calibration(const pipeline::PipelineConfig& config) {
  pipeline::PipelineConfig check = config;
  check.segmentation.mode = segmentation::SegmentationMode::kNone;
  check.calibration.mode = rig::RefineMode::kOn;  // Corrects wrong rows, so that matching succeeds.
  return check;
}

Status watch(const CameraSetup& setup, const GuardedCamera& camera, const DoctorOptions& options,
             const AppConfig& config, Arena& arena, Watched& watched) {
  auto rectifier = hal::Rectifier::create(setup.calibration, config.rectification, arena);
  if (!rectifier) {
    return Unexpected(rectifier.error());
  }
  const StereoGeometry& geometry = rectifier->geometry();
  auto monitor = hal::InputMonitor::create(kMonitor, geometry.width_px, geometry.height_px, arena);
  if (!monitor) {
    return Unexpected(monitor.error());
  }
  auto odometry = pipeline::Pipeline::create(only_calibration(config.pipeline), geometry, arena);
  if (!odometry) {
    return Unexpected(odometry.error());
  }
  HealthMonitor health;
  Progress progress(false, std::nullopt);
  const CameraLoop loop{*camera.camera, {.max_seconds = options.seconds}, false, health, progress};
  Status played = play_camera(loop, [&](const StereoFrame& frame) -> Status {
    watched.add(frame.timestamp_ns);
    const Result<RectifiedPair> pair = rectifier->process(frame);
    if (!pair) {
      return Unexpected(pair.error());
    }
    if (monitor->process(frame, *pair)) {
      watched.pairing = monitor->sync();
      watched.residual_sum_px += watched.pairing.residual_px;
    }
    const Result<const FrameResult*> result = odometry->process(*pair);
    if (!result) {
      return Unexpected(result.error());
    }
    watched.rig = (*result)->rig;
    if (watched.rig.verdict == RigVerdict::kCorrected) {
      watched.rig.verdict = RigVerdict::kOff;
    }
    return {};
  });
  // Rows and pairing are separate checks.
  for (const hal::InputFault fault :
       {hal::InputFault::kViewsIdentical, hal::InputFault::kViewsExchanged, hal::InputFault::kViewsUnrelated,
        hal::InputFault::kNoParallax, hal::InputFault::kBeyondInfinity, hal::InputFault::kLeftFrozen,
        hal::InputFault::kRightFrozen}) {
    if (monitor->holds(fault)) {
      watched.faults.push_back(
          describe(fault, *monitor, {"camera file " + options.camera, setup.calibration.source}, geometry));
    }
  }
  return played;
}

void assess_timing(const Watched& watched, const GuardedCamera& camera, Findings& findings) {
  const double nominal_hz = camera.camera->info().nominal_rate_hz;
  constexpr double kTolerance = 0.1;
  findings.check(std::abs(watched.rate_hz() - nominal_hz) <= kTolerance * nominal_hz, "rate",
                 formatted("%.2f Hz", watched.rate_hz()) + formatted(" of %.2f Hz", nominal_hz) +
                     formatted(", steps %.1f", static_cast<double>(watched.shortest_ns) / kNanosecondsPerMs) +
                     formatted(" to %.1f ms", static_cast<double>(watched.longest_ns) / kNanosecondsPerMs),
                 "shorten the exposure, add light, or use a USB port of its own for each camera");
  const hal::CameraCounters& counted = camera.camera->counters();
  const std::uint64_t lost =
      counted.gaps + counted.skipped_missing_side + counted.skipped_unreadable + counted.skipped_repeated;
  findings.check(lost * 100 <= static_cast<std::uint64_t>(watched.frames), "losses",
                 std::to_string(watched.frames) + " frames; " + std::to_string(counted.gaps) + " lost, " +
                     std::to_string(counted.skipped_missing_side) + " without partner, " +
                     std::to_string(counted.skipped_unreadable) + " damaged, " +
                     std::to_string(counted.skipped_repeated) + " with times that do not advance",
                 "lower rate or size, use a compressed format, better cables, or triggered cameras");
  if (camera.live != nullptr) {
    const hal::PairingStatus pairing = camera.live->pairing();
    const double period_ms = 1e3 / nominal_hz;
    findings.check(
        std::abs(pairing.offset_ms) <= period_ms / 4, "skew",
        formatted("right is %.2f ms later", pairing.offset_ms) + formatted(", drifting %.0f ppm", pairing.drift_ppm),
        "connect a trigger line, or set image.trigger to external");
  }
}

// Images far apart in time give little or no evidence of the pairing, however the camera is moved.
std::string pairing_text(const hal::SyncReport& pairing) {
  const std::string seen = pairing.verdict == hal::SyncVerdict::kUnknown
                               ? "not seen: nod the camera while this runs to check it"
                               : to_string(pairing.verdict) + (" in " + std::to_string(pairing.agreeing)) + " looks";
  const std::string apart = "; frames looked at were " + std::to_string(pairing.frames_apart) + " apart";
  return pairing.frames_apart > 1 ? seen + apart + ", 1 is best: close other programs, or lower image.rate_hz"
                                  : seen + apart;
}

// Rows and yaw: rows are observable in every pair, the yaw once the camera has moved.
void assess_calibration(const Watched& watched, const StereoGeometry& geometry, Findings& findings) {
  constexpr double kMax_px = 1.0;
  const double residual_px = watched.residual_sum_px / watched.pairing.measurements;
  findings.check(residual_px <= kMax_px, "calibration",
                 formatted("matches lie %.2f px off their row", residual_px) + ", " +
                     std::to_string(watched.pairing.matches) + " matches",
                 "calibrate again in this mode");
  findings.check(watched.rig.verdict != RigVerdict::kOff, "yaw", rig_text(watched.rig, geometry),
                 "calibrate again, or leave calibration.refine: on");
}

void assess_images(const Watched& watched, const StereoGeometry& geometry, Findings& findings) {
  constexpr int kMinMatches = 12;
  const hal::SyncReport& pairing = watched.pairing;
  for (const std::string& fault : watched.faults) {
    findings.failed("images", fault);
  }
  if (pairing.measurements == 0 || pairing.matches < kMinMatches) {
    findings.failed("images", std::to_string(pairing.matches) +
                                  " matches between the views; point both at something with texture, in light");
    return;
  }
  assess_calibration(watched, geometry, findings);
  const bool is_off =
      pairing.verdict == hal::SyncVerdict::kRightLate || pairing.verdict == hal::SyncVerdict::kRightEarly;
  findings.check(!is_off, "pairing", pairing_text(pairing),
                 "trigger both cameras together; `kinetrace run` mends this for two devices");
}

void assess_geometry(const StereoGeometry& geometry, const hal::RigCalibration& calibration, Findings& findings) {
  findings.ok("rig", calibration.source + ": " + std::to_string(geometry.width_px) + "x" +
                         std::to_string(geometry.height_px) + formatted(", focal length %.1f px", geometry.fx_px) +
                         formatted(", baseline %.4f m", geometry.baseline_m));
}

// The network that a run would use, started; null if a run would use none, with the reason.
std::unique_ptr<NetworkThread> network_of(AppConfig& config, const StereoGeometry& geometry, const PlanRun& plan_run,
                                          Findings& findings) {
  Result<StartedNetwork> network = start_network(config, geometry, true, plan_run);
  if (!network) {
    findings.failed("network", network.error().message);
    return nullptr;
  }
  if (network->why_none) {
    findings.ok("network", *network->why_none);
  }
  return std::move(network->thread);
}

void assess_model(const AppConfig& config, NetworkThread* network, const StereoGeometry& geometry, double rate_hz,
                  Findings& findings) {
  if (network != nullptr) {
    const ModelFinding model = examine_model(config, *network, geometry, rate_hz);
    model.holds ? findings.ok("network", model.detail) : findings.failed("network", model.detail);
  }
}

void assess_memory(const RunMemory& plan, const pipeline::MemoryConfig& memory, Findings& findings) {
  constexpr double kMib = 1024.0 * 1024.0;
  const Status fits = check_budget(plan, memory);
  const std::string planned =
      formatted("%.1f MiB planned", static_cast<double>(plan.arena.total_bytes()) / kMib) +
      formatted(" and %.1f MiB for libraries and threads", static_cast<double>(plan.outside.total_bytes()) / kMib);
  fits ? findings.ok("memory", planned + (memory.budget_mib > 0.0 ? formatted(" of %.1f MiB", memory.budget_mib)
                                                                  : ", which is the budget: none is given"))
       : findings.failed("memory", fits.error().message);
}

void examine(const CameraSetup& setup, AppConfig& config, const DoctorOptions& options,
             const PublishingSetup* publishing, Findings& findings) {
  const auto geometry = hal::Rectifier::rectified_geometry(setup.calibration, config.rectification);
  if (!geometry) {
    findings.failed("rig", geometry.error().message);
    return;
  }
  const PlanRun plan_run = [&](const AppConfig& planned, const NetworkThread* with) {
    return plan_memory(planned, setup, {}, publishing, with);
  };
  const std::unique_ptr<NetworkThread> network = network_of(config, *geometry, plan_run, findings);
  const Result<RunMemory> plan = plan_run(config, network.get());
  if (!plan) {
    findings.failed("rig", plan.error().message);
    return;
  }
  assess_geometry(*geometry, setup.calibration, findings);
  assess_memory(*plan, config.pipeline.memory, findings);

  Arena arena(setup.required_bytes() + hal::Rectifier::required_bytes(setup.calibration, config.rectification) +
              hal::InputMonitor::required_bytes(kMonitor, geometry->width_px, geometry->height_px) +
              pipeline::Pipeline::plan(only_calibration(config.pipeline), *geometry)
                  .transform([](const MemoryPlan& needed) { return needed.total_bytes(); })
                  .value_or(0) +
              2 * Arena::kAlignment);
  auto camera = setup.make(arena);
  if (!camera) {
    findings.failed("camera", camera.error().message);
    return;
  }
  for (const Status& begun : {camera->camera->open(), camera->camera->start()}) {
    if (!begun) {
      findings.failed("camera", begun.error().message);
      return;
    }
  }
  findings.ok("camera", camera->camera->info().name);
  Watched watched;
  if (const Status seen = watch(setup, *camera, options, config, arena, watched); !seen) {
    findings.failed("stream", seen.error().message);
    return;
  }
  assess_timing(watched, *camera, findings);
  assess_images(watched, *geometry, findings);
  assess_model(config, network.get(), *geometry, camera->camera->info().nominal_rate_hz, findings);
}

void examine_camera(const DoctorOptions& options, AppConfig& config, Findings& findings) {
  SourceOptions source;
  source.camera = options.camera;
  Outcome<CameraSetup> setup = camera_setup(source);
  if (!setup) {
    findings.failed("config", setup.error().message);
    return;
  }
  // Its error has been reported; its memory is then not counted.
  auto publishing = optional_publishing(options.publish, config.pipeline.tracking.max_objects).value_or(nullptr);
  // The rate must be measured on raw times, not on repaired ones.
  setup->repairs_timestamps = false;
  catch_interrupts();
  examine(*setup, config, options, publishing.get(), findings);
}

// Without a camera, the plan assumes a common one.
void examine_network_alone(AppConfig& config, Findings& findings) {
  constexpr double kRate_hz = 10.0;
  const StereoGeometry geometry{.width_px = config.board.image_width_px, .height_px = config.board.image_height_px};
  const std::unique_ptr<NetworkThread> network = network_of(
      config, geometry,
      [](const AppConfig& planned, const NetworkThread* with) {
        return plan_memory(planned, camera_of(planned.board), {}, nullptr, with);
      },
      findings);
  assess_model(config, network.get(), geometry, kRate_hz, findings);
}

int doctor_command(const DoctorOptions& options) {
  Result<AppConfig> config = load_config(options.config);
  if (!config) {
    return report(to_failure(config.error()));
  }
  Findings findings;
  list_devices(findings);
  const NetworkFinding network = examine_network(options.publish);
  network.holds ? findings.ok("dds", network.detail) : findings.failed("dds", network.detail);
  if (!options.camera.empty()) {
    examine_camera(options, *config, findings);
  } else {
    examine_network_alone(*config, findings);
  }
  return findings.all_held() ? 0 : static_cast<int>(ExitCode::kConditionHolds);
}

void add_options(CLI::App& doctor, DoctorOptions& options) {
  doctor.add_option("CAMERA", options.camera, "Camera file; without it, the devices of this machine are listed");
  doctor.add_option("--publish", options.publish, "File of the run's --publish; without it, the defaults of DDS");
  doctor.add_option("--seconds", options.seconds, "Duration of the check of the images")
      ->type_name("S")
      ->check(number_within(0.1, 3600.0))
      ->capture_default_str();
  add_config_options(doctor, options.config);
}

}  // namespace

Action add_doctor(CLI::App& command) {
  return bind_options(command, add_options, doctor_command);
}

}  // namespace kinetrace::app
