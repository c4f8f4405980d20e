#include "run/frame_processor.hpp"

#include <utility>

#include "live/clocks.hpp"
#include "live/realtime.hpp"

namespace kinetrace::app {

Status FrameProcessor::go_live(const RunSetup& setup, double rate_hz, Arena& arena) {
  capture_clock_ = std::make_unique<StageClock>();
  LiveRun::Processing processing{.process =
                                     [this](const RectifiedPair& pair, std::int64_t exposed_ns) {
                                       clock_->begin_frame();
                                       return process_pair(pair, exposed_ns);
                                     },
                                 .idle = [this] { publish_health(); },
                                 .limit = [this](const Effort& effort) { components_.pipeline.limit(effort); },
                                 .max_objects = setup.config.pipeline.tracking.max_objects};
  auto live = LiveRun::create(setup.config.live, rate_hz, !setup.camera.live, components_.rectifier.geometry(),
                              std::move(processing), report_.health, arena);
  if (!live) {
    return Unexpected(live.error());
  }
  live_ = std::move(*live);
  if (const int priority = setup.config.live.realtime_priority; priority > 0) {
    if (const Status allowed = request_realtime(priority); !allowed) {
      report_.warn_now(allowed.error().message + ". Continuing without");
    }
  }
  return {};
}

Status FrameProcessor::process(const StereoFrame& frame) {
  if (live_) {
    live_->await(frame);
  }
  capture_clock().begin_frame();
  const Result<RectifiedPair> pair = prepare(frame);
  if (!pair) {
    return Unexpected(pair.error());
  }
  if (!live_) {
    return process_pair(*pair, 0);  // Latency from exposure has no meaning for a recording.
  }
  capture_clock().end_frame();
  Status offered = live_->offer(*pair);
  allocations_at_last_offer_ = allocation_counts();
  return offered;
}

Status FrameProcessor::finish() {
  if (Status ended = live_ ? live_->finish() : Status{}; !ended) {
    return ended;
  }
  return components_.mask_files ? components_.mask_files->finish(components_.pipeline.mask_complaint(), warn_)
                                : Status{};
}

void FrameProcessor::on_idle() {
  // Waiting for a lost or silent camera counts as progress. While frames arrive, only results do.
  if (report_.health.camera() != hal::CameraState::kStreaming) {
    components_.service->progress(steady_time_ns());
    components_.service->tell(report_.health.condition());
  }
  if (!live_) {
    publish_health();
  }
}

Processed FrameProcessor::processed() const {
  Processed processed = progressed_.get();
  if (live_) {
    processed.allocations = allocations_at_last_offer_;
  }
  return processed;
}

Result<RectifiedPair> FrameProcessor::prepare(const StereoFrame& frame) {
  record_raw(frame);
  Result<RectifiedPair> pair = [&] {
    const StageScope scope(&capture_clock(), Stage::kRectify);
    // In live mode the workers belong to the processing thread.
    return components_.rectifier.process(frame, live_ ? nullptr : components_.workers.get());
  }();
  if (pair) {
    if (const Status usable = components_.input.process(
            frame, *pair, report_.health, warn_,
            {.refines = components_.refines_calibration, .corrected = calibration_corrected_});
        !usable) {
      return Unexpected(usable.error());
    }
  }
  return pair;
}

// A failure of recording must not stop the run.
void FrameProcessor::record_raw(const StereoFrame& frame) {
  if (!components_.raw) {
    return;
  }
  if (components_.waits_for_disk) {
    components_.raw->wait_for_room();
  }
  components_.raw->offer(frame);
  if (const std::optional<Error> stopped = components_.raw->stopped_by()) {
    report_.warn_now(raw_stopped(*stopped));
    report_.health.note(HealthReason::kRecordingStopped);
    components_.raw_ended = std::move(components_.raw);
  }
}

Status FrameProcessor::process_pair(const RectifiedPair& pair, std::int64_t exposed_ns) {
  const Result<const FrameResult*> result = components_.pipeline.process(pair, clock_.get());
  if (!result) {
    return Unexpected(result.error());
  }
  report_.health.observe((*result)->newest);
  calibration_corrected_ = (*result)->rig.verdict == RigVerdict::kCorrected;
  if (Status usable = note_masks(**result); !usable) {
    return usable;
  }
  offer_result(**result, exposed_ns);
  clock_->end_frame();
  Status recorded = components_.recorder.record(**result);
  if ((*result)->has_finalised) {
    report_.add_finalised((*result)->finalised);
  }
  progressed_.set({.frames = progressed_.get().frames + 1,
                   .objects_now = static_cast<int>((*result)->newest.objects.size()),
                   .counters = (*result)->counters,
                   .rig = (*result)->rig,
                   .allocations = allocation_counts()});
  components_.service->progress(steady_time_ns());
  components_.service->tell(report_.health.condition());
  if (components_.publishing) {
    components_.publishing->send();
  }
  return recorded;
}

Status FrameProcessor::note_masks(const FrameResult& result) {
  if (components_.mask_fit) {
    if (Status fits = components_.mask_fit->process(result, report_.health, warn_); !fits) {
      return fits;
    }
  }
  if (components_.mask_files) {
    return components_.mask_files->process(result.counters, result.newest.timestamp_ns,
                                           components_.pipeline.mask_complaint(), report_.health, warn_);
  }
  if (components_.masks || components_.network) {
    report_.health.note(HealthReason::kMasksMissing, result.counters.detection_frames_missing - mask_frames_missing_);
    mask_frames_missing_ = result.counters.detection_frames_missing;
  }
  return {};
}

void FrameProcessor::offer_result(const FrameResult& result, std::int64_t exposed_ns) {
  if (!components_.publishing) {
    return;
  }
  const StageScope scope(clock_.get(), Stage::kPublish);
  report_.health.note(HealthReason::kNotPublished, components_.publishing->is_connected() ? 0 : 1);
  components_.publishing->offer_health(report_.health, result.counters, result.rig);
  components_.publishing->offer(result, exposed_ns);
}

void FrameProcessor::publish_health() {
  if (components_.publishing) {
    components_.publishing->offer_health(report_.health, progressed_.get().counters, progressed_.get().rig);
  }
}

}  // namespace kinetrace::app
