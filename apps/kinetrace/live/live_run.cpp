#include "live/live_run.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "cli/interrupt.hpp"
#include "live/clocks.hpp"

namespace kinetrace::app {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::int64_t Pacer::wait_for(std::int64_t timestamp_ns) {
  constexpr std::chrono::nanoseconds kMaxNap = std::chrono::milliseconds(100);
  const std::int64_t came_ns = steady_time_ns();
  if (!first_timestamp_ns_) {
    first_timestamp_ns_ = timestamp_ns;
    first_due_ns_ = came_ns;
  }
  const auto passed_ns = static_cast<double>(timestamp_ns - *first_timestamp_ns_) / speed_;
  const std::int64_t due_ns = first_due_ns_ + static_cast<std::int64_t>(passed_ns);
  for (std::int64_t left_ns = due_ns - steady_time_ns(); left_ns > 0 && interrupted_by() == 0;
       left_ns = due_ns - steady_time_ns()) {
    std::this_thread::sleep_for(std::min(kMaxNap, std::chrono::nanoseconds(left_ns)));
  }
  // A delay by the disk shifts all later frames.
  const std::int64_t delay_ns = std::max<std::int64_t>(0, came_ns - due_ns);
  first_due_ns_ += delay_ns;
  return due_ns + delay_ns;
}

LiveRun::LiveRun(const LiveConfig& config, double nominal_rate_hz, bool is_paced, Processing processing,
                 HealthMonitor& health)
    : processing_(std::move(processing)),
      health_(health),
      pacer_(is_paced ? std::optional<Pacer>(config.speed) : std::nullopt),
      reduces_effort_(config.shed),
      deadline_ms_(config.deadline_ms > 0.0 ? config.deadline_ms
                                            : 1e3 / (nominal_rate_hz * (is_paced ? config.speed : 1.0))),
      shedder_(deadline_ms_, processing_.max_objects) {}

Result<std::unique_ptr<LiveRun>> LiveRun::create(const LiveConfig& config, double nominal_rate_hz, bool is_paced,
                                                 const StereoGeometry& geometry, Processing processing,
                                                 HealthMonitor& health, Arena& arena) {
  std::unique_ptr<LiveRun> made(new LiveRun(config, nominal_rate_hz, is_paced, std::move(processing), health));
  auto thread = PipelineThread::create(
      geometry,
      [run = made.get()](const RectifiedPair& pair, std::int64_t exposed_ns) { return run->process(pair, exposed_ns); },
      [run = made.get()] { run->processing_.idle(); }, arena);
  if (!thread) {
    return Unexpected(thread.error());
  }
  made->thread_ = std::move(*thread);
  return made;
}

void LiveRun::await(const StereoFrame& frame) {
  // Repaired times of a camera may be ahead of the clock.
  due_ns_ = pacer_ ? pacer_->wait_for(frame.timestamp_ns) : std::min(frame.timestamp_ns, steady_time_ns());
}

Status LiveRun::offer(const RectifiedPair& pair) {
  const Result<bool> left_out = thread_->offer(pair, due_ns_);
  if (!left_out) {
    return Unexpected(left_out.error());
  }
  left_out_ += *left_out ? 1 : 0;
  health_.note(HealthReason::kFramesOutdated, *left_out ? 1 : 0);
  return {};
}

Status LiveRun::process(const RectifiedPair& pair, std::int64_t exposed_ns) {
  const Clock::time_point begun = Clock::now();
  if (Status processed = processing_.process(pair, exposed_ns); !processed) {
    return processed;
  }
  latency_.add(steady_time_ns() - exposed_ns);
  adapt(Clock::now() - begun);
  return {};
}

void LiveRun::adapt(Clock::duration took) {
  const double took_ms = std::chrono::duration<double, std::milli>(took).count();
  late_ += took_ms > deadline_ms_ ? 1 : 0;
  if (!reduces_effort_) {
    return;
  }
  if (shedder_.update(took_ms)) {
    processing_.limit(shedder_.effort());
    worst_level_ = std::max(worst_level_, shedder_.level());
  }
  if (const std::optional<HealthReason> reason = shedder_.health_reason()) {
    health_.note(*reason);
  }
}

recording::LiveSummary LiveRun::summary() const noexcept {
  return {.deadline_ms = deadline_ms_,
          .frames_late = late_,
          .frames_left_out = left_out_,
          .level = shedder_.level(),
          .worst_level = worst_level_,
          .latency = latency_.quantiles()};
}

}  // namespace kinetrace::app
