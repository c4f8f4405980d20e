#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "camera_loop.hpp"
#include "camera_setup.hpp"
#include "commands.hpp"
#include "interrupt.hpp"
#include "kinetrace/core/config_check.hpp"
#include "messages.hpp"
#include "progress.hpp"
#include "recording_thread.hpp"

namespace kinetrace::app {
namespace {

struct Recorded {
  std::int64_t written = 0;
  std::uint64_t dropped = 0;
  hal::CameraCounters counters;
};

double rate_of(const CameraSetup& setup) {
  return setup.live ? setup.live->left.rate_hz : setup.dataset->nominal_rate_hz;
}

// With nothing else to go on for, a recording that has stopped is the end.
Status record_frame(RecordingThread& raw, const StereoFrame& frame, bool waits_for_disk) {
  if (waits_for_disk) {
    raw.wait_for_room();
  }
  raw.offer(frame);
  const std::optional<Error> failure = raw.stopped_by();
  return failure ? Unexpected(*failure) : Status{};
}

Outcome<Recorded> record(const RecordOptions& options) {
  const Outcome<CameraSetup> setup = camera_setup(options.source);
  if (!setup) {
    return Unexpected(setup.error());
  }
  const hal::RawRecorderConfig config = raw_recorder_config(options.raw, setup->calibration, rate_of(*setup));
  Arena arena(setup->required_bytes() + RecordingThread::required_bytes(config));
  auto camera = setup->make(arena);
  if (!camera) {
    return failure(camera.error());
  }
  hal::StereoCamera& frames = *camera->camera;
  if (const Status begun = first_failure({frames.open(), frames.start()}); !begun) {
    return failure(begun.error());
  }
  // Last, so that no folder is made unless there is something to record.
  auto raw = RecordingThread::create(config, arena);
  if (!raw) {
    return Unexpected(raw.error());
  }
  HealthMonitor health;
  Progress progress(!options.quiet, frames.info().frame_count);
  catch_interrupts();
  const CameraLoop loop{frames, options.until, setup->is_camera, health, progress};
  Status played = play_camera(loop, [&](const StereoFrame& frame) {
    Status recorded = record_frame(**raw, frame, !setup->live);
    progress.show((*raw)->written(), 0);
    return recorded;
  });
  progress.clear();
  (*raw)->finish();
  if (const std::optional<Error> failed = (*raw)->stopped_by(); played && failed) {
    played = Unexpected(*failed);
  }
  const Recorded recorded{(*raw)->written(), (*raw)->dropped(), frames.counters()};
  if (!played) {
    print_warning(std::to_string(recorded.written) + " frames were recorded before");
    return failure(played.error());
  }
  return recorded;
}

}  // namespace

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
    std::printf("%lld frames in %s; lost before: %llu\n", static_cast<long long>(recorded->written),
                options.raw.out.c_str(), static_cast<unsigned long long>(lost.gaps + lost.skipped_missing_side));
  }
  return interrupted_by() == 0 ? 0 : kSignalBase + interrupted_by();
}

}  // namespace kinetrace::app
