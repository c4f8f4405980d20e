#include "frame_processor.hpp"

#include <utility>

#include "clocks.hpp"
#include "realtime.hpp"

namespace kinetrace::app {

Status FrameProcessor::go_live(const AppConfig& config, const CameraSetup& setup, double rate_hz, Arena& arena) {
  capture_clock_ = std::make_unique<StageClock>();
  LiveRun::Processing processing{.process =
                                     [this](const RectifiedPair& pair, std::int64_t exposed_ns) {
                                       clock_->begin_frame();
                                       return process(pair, exposed_ns);
                                     },
                                 .idle = [this] { tell_health(); },
                                 .limit = [this](const Effort& effort) { chain_.pipeline.limit(effort); },
                                 .max_objects = config.pipeline.tracking.max_objects};
  auto live = LiveRun::create(config.live, rate_hz, !setup.live, chain_.rectifier.geometry(), std::move(processing),
                              report_.health, arena);
  if (!live) {
    return Unexpected(live.error());
  }
  live_ = std::move(*live);
  if (const int priority = config.live.realtime_priority; priority > 0) {
    if (const Status allowed = request_realtime(priority); !allowed) {
      report_.warn_now(allowed.error().message + ". Going on without");
    }
  }
  return {};
}

Status FrameProcessor::play(const StereoFrame& frame) {
  if (live_) {
    live_->await(frame);
  }
  capture_clock().begin_frame();
  const Result<RectifiedPair> pair = prepare(frame);
  if (!pair) {
    return Unexpected(pair.error());
  }
  if (!live_) {
    return process(*pair, 0);  // A recording was exposed long ago.
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
  return chain_.mask_files ? chain_.mask_files->finish(chain_.pipeline.mask_complaint(), warn_) : Status{};
}

void FrameProcessor::on_idle() {
  // Waiting for a camera that has gone, or is silent, is what a run is to do then. While frames come, only results
  // count.
  if (report_.health.camera() != hal::CameraState::kStreaming) {
    chain_.service->progress(steady_time_ns());
    chain_.service->tell(report_.health.condition());
  }
  if (!live_) {
    tell_health();
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
    // Live, the workers belong to the thread that processes.
    return chain_.rectifier.process(frame, live_ ? nullptr : chain_.workers.get());
  }();
  if (pair) {
    if (const Status usable = chain_.input.process(frame, *pair, report_.health, warn_); !usable) {
      return Unexpected(usable.error());
    }
  }
  return pair;
}

// Recording must not stop anything else.
void FrameProcessor::record_raw(const StereoFrame& frame) {
  if (!chain_.raw) {
    return;
  }
  if (chain_.waits_for_disk) {
    chain_.raw->wait_for_room();
  }
  chain_.raw->offer(frame);
  if (const std::optional<Error> stopped = chain_.raw->stopped_by()) {
    report_.warn_now(raw_stopped(*stopped));
    report_.health.note(HealthReason::kRecordingStopped);
    chain_.raw_ended = std::move(chain_.raw);
  }
}

Status FrameProcessor::process(const RectifiedPair& pair, std::int64_t exposed_ns) {
  const Result<const FrameResult*> result = chain_.pipeline.process(pair, clock_.get());
  if (!result) {
    return Unexpected(result.error());
  }
  report_.health.observe((*result)->newest);
  if (Status usable = note_masks(**result); !usable) {
    return usable;
  }
  hand_over(**result, exposed_ns);
  clock_->end_frame();
  Status recorded = chain_.recorder.record(**result);
  if ((*result)->has_settled) {
    report_.add_settled((*result)->settled);
  }
  progressed_.set({.frames = progressed_.get().frames + 1,
                   .objects_now = static_cast<int>((*result)->newest.objects.size()),
                   .counters = (*result)->counters,
                   .allocations = allocation_counts()});
  chain_.service->progress(steady_time_ns());
  chain_.service->tell(report_.health.condition());
  if (chain_.publishing) {
    chain_.publishing->send();
  }
  return recorded;
}

Status FrameProcessor::note_masks(const FrameResult& result) {
  if (chain_.mask_files) {
    return chain_.mask_files->process(result.counters, result.newest.timestamp_ns, chain_.pipeline.mask_complaint(),
                                      report_.health, warn_);
  }
  if (chain_.masks || chain_.network) {
    report_.health.note(HealthReason::kMasksMissing, result.counters.detection_frames_missing - mask_frames_missing_);
    mask_frames_missing_ = result.counters.detection_frames_missing;
  }
  return {};
}

void FrameProcessor::hand_over(const FrameResult& result, std::int64_t exposed_ns) {
  if (!chain_.publishing) {
    return;
  }
  const StageScope scope(clock_.get(), Stage::kPublish);
  report_.health.note(HealthReason::kNotPublished, chain_.publishing->is_connected() ? 0 : 1);
  chain_.publishing->offer_health(report_.health, result.counters);
  chain_.publishing->offer(result, exposed_ns);
}

void FrameProcessor::tell_health() {
  if (chain_.publishing) {
    chain_.publishing->offer_health(report_.health, progressed_.get().counters);
  }
}

}  // namespace kinetrace::app
