#include "kinetrace/hal/timeline_guard.hpp"

namespace kinetrace::hal {

bool TimelineGuard::fits(std::int64_t step_ns, std::int64_t expected_step_ns,
                         std::int64_t shortest_step_ns) const noexcept {
  return (step_ns > 0 || !must_advance_) && step_ns >= shortest_step_ns - tolerance_ns_ &&
         step_ns <= expected_step_ns + tolerance_ns_;
}

TimelineGuard::Step TimelineGuard::correct(std::int64_t stamp_ns, std::int64_t expected_step_ns,
                                           std::int64_t shortest_step_ns) noexcept {
  Step step{stamp_ns + shift_ns_, false};
  if (last_ns_ && !fits(step.time_ns - *last_ns_, expected_step_ns, shortest_step_ns)) {
    // A clock that was wrong for a while is right again when its own times fit.
    const bool is_back = shift_ns_ != 0 && fits(stamp_ns - *last_ns_, expected_step_ns, shortest_step_ns);
    step = {is_back ? stamp_ns : *last_ns_ + expected_step_ns, true};
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
