#include "kinetrace/hal/timeline_guard.hpp"

namespace kinetrace::hal {

bool TimelineGuard::fits(std::int64_t step_ns, const Evidence& evidence) const noexcept {
  return (step_ns > 0 || !must_advance_) && step_ns >= evidence.shortest_ns - tolerance_ns_ &&
         step_ns <= evidence.longest_ns + tolerance_ns_;
}

TimelineGuard::Step TimelineGuard::correct(std::int64_t stamp_ns, const Evidence& evidence) noexcept {
  Step step{stamp_ns + shift_ns_, false};
  if (last_ns_ && !fits(step.time_ns - *last_ns_, evidence)) {
    // A clock that was wrong for a while is trusted again when its own times fit.
    const bool is_back = shift_ns_ != 0 && fits(stamp_ns - *last_ns_, evidence);
    step = {is_back ? stamp_ns : *last_ns_ + evidence.expected_ns, true};
    shift_ns_ = step.time_ns - stamp_ns;
  }
  last_ns_ = step.time_ns;
  return step;
}

void TimelineGuard::reset() noexcept {
  shift_ns_ = 0;
  last_ns_.reset();
}

}  // namespace kinetrace::hal
