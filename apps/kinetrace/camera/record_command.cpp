#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "camera/camera_loop.hpp"
#include "camera/camera_setup.hpp"
#include "camera/input_watch.hpp"
#include "camera/recording_thread.hpp"
#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "cli/shared_options.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/hal/rectifier.hpp"

namespace kinetrace::app {
namespace {

struct RecordOptions {
  SourceOptions source;
  UntilOptions until;
  RawOutputOptions raw;
  bool quiet = false;
};

struct Recorded {
  std::int64_t written = 0;
  std::uint64_t dropped = 0;
  hal::CameraCounters counters;
};

// Recording is the only purpose here, so its failure ends the command.
Status record_frame(RecordingThread& raw, const StereoFrame& frame, bool waits_for_disk) {
  if (waits_for_disk) {
    raw.wait_for_room();
  }
  raw.offer(frame);
  const std::optional<Error> failure = raw.stopped_by();
  return failure ? Unexpected(*failure) : Status{};
}

/// Reports faults of the images while they can still be recorded anew. Recording continues in any case.
class RecordWatch {
 public:
  [[nodiscard]] static Result<std::size_t> required_bytes(const CameraSetup& setup) {
    const auto geometry = hal::Rectifier::rectified_geometry(setup.calibration, {});
    if (!geometry) {
      return Unexpected(geometry.error());
    }
    return hal::Rectifier::required_bytes(setup.calibration, {}) +
           hal::InputMonitor::required_bytes({}, geometry->width_px, geometry->height_px) + 2 * Arena::kAlignment;
  }
  [[nodiscard]] static Result<RecordWatch> create(const CameraSetup& setup, Arena& arena) {
    auto rectifier = hal::Rectifier::create(setup.calibration, {}, arena);
    if (!rectifier) {
      return Unexpected(rectifier.error());
    }
    const StereoGeometry& geometry = rectifier->geometry();
    const auto monitor = hal::InputMonitor::create({}, geometry.width_px, geometry.height_px, arena);
    if (!monitor) {
      return Unexpected(monitor.error());
    }
    return RecordWatch(*rectifier, InputWatch(*monitor, PairingKeeper(nullptr), InputPolicy::kWarn,
                                              {setup.images, setup.calibration.source}));
  }
  void process(const StereoFrame& frame, HealthMonitor& health, const Warn& warn) {
    const Result<RectifiedPair> pair = watch_.wants_pair() ? rectifier_.process(frame) : RectifiedPair{};
    const Status seen = pair ? watch_.process(frame, *pair, health, warn) : Unexpected(pair.error());
    if (!seen) {
      warn(seen.error().message);
    }
  }

 private:
  RecordWatch(const hal::Rectifier& rectifier, InputWatch watch) : rectifier_(rectifier), watch_(std::move(watch)) {}
  hal::Rectifier rectifier_;
  InputWatch watch_;
};

// Records the camera's frames until the end; `watch` may be null.
Status record_frames(const RecordOptions& options, const CameraSetup& setup, hal::StereoCamera& camera,
                     RecordingThread& raw, RecordWatch* watch) {
  HealthMonitor health;
  Progress progress(!options.quiet, camera.info().frame_count);
  const Warn warn = [&progress](const std::string& warning) {
    progress.clear();
    print_warning(warning);
  };
  catch_interrupts();
  const CameraLoop loop{camera, options.until, setup.is_camera, health, progress};
  Status played = play_camera(loop, [&](const StereoFrame& frame) -> Status {
    if (Status recorded = record_frame(raw, frame, !setup.live); !recorded) {
      return recorded;
    }
    progress.show(raw.written(), 0);
    if (watch != nullptr) {
      watch->process(frame, health, warn);
    }
    return {};
  });
  progress.clear();
  raw.finish();
  const std::optional<Error> failed = raw.stopped_by();
  return played && failed ? Unexpected(*failed) : played;
}

Outcome<Recorded> record(const RecordOptions& options) {
  const Outcome<CameraSetup> setup = camera_setup(options.source);
  if (!setup) {
    return Unexpected(setup.error());
  }
  const hal::RawRecorderConfig config = raw_recorder_config(options.raw, setup->calibration, setup->rate_hz());
  if (const Outcome<void> can = RecordingThread::check(config, setup->folder); !can) {
    return Unexpected(can.error());
  }
  // Images without a valid calibration can be recorded, to be calibrated later.
  const Result<std::size_t> watch_bytes = RecordWatch::required_bytes(*setup);
  if (!watch_bytes) {
    print_warning(watch_bytes.error().message + "; recording without a look at the images");
  }
  Arena arena(setup->required_bytes() + RecordingThread::required_bytes(config) + watch_bytes.value_or(0));
  auto camera = setup->make(arena);
  if (!camera) {
    return failure(camera.error());
  }
  std::optional<RecordWatch> watch;
  if (watch_bytes) {
    auto made = RecordWatch::create(*setup, arena);
    if (!made) {
      return failure(made.error());
    }
    watch = std::move(*made);
  }
  hal::StereoCamera& frames = *camera->camera;
  if (const Status begun = first_failure({frames.open(), frames.start()}); !begun) {
    return failure(begun.error());
  }
  // Last, so that no folder is created before the camera is ready.
  auto raw = RecordingThread::create(config, arena);
  if (!raw) {
    return Unexpected(raw.error());
  }
  const Status played = record_frames(options, *setup, frames, **raw, watch ? &*watch : nullptr);
  const Recorded recorded{(*raw)->written(), (*raw)->dropped(), frames.counters()};
  if (!played) {
    print_warning(std::to_string(recorded.written) + " frames were recorded before");
    return failure(played.error());
  }
  return recorded;
}

int record_command(const RecordOptions& options) {
  const Outcome<Recorded> recorded = record(options);
  if (!recorded) {
    return report(recorded.error());
  }
  if (recorded->dropped > 0) {
    print_warning(std::to_string(recorded->dropped) + " frames were dropped: the disk is too slow");
  }
  if (!options.quiet) {
    const hal::CameraCounters& lost = recorded->counters;
    std::printf("%s frames in %s; lost before: %s\n", std::to_string(recorded->written).c_str(),
                options.raw.out.c_str(), std::to_string(lost.gaps + lost.skipped_missing_side).c_str());
  }
  return interrupted_by() == 0 ? 0 : kSignalBase + interrupted_by();
}

void add_options(CLI::App& record, RecordOptions& options) {
  add_source_options(record, options.source);
  CLI::Option* out = record.add_option("--out", options.raw.out, "New folder")->type_name("DIR")->required();
  add_until_options(record, options.until);
  add_raw_options(record, options.raw, out);
  record.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace

Action add_record(CLI::App& command) {
  return bind_options(command, add_options, record_command);
}

}  // namespace kinetrace::app
