#include "kinetrace/hal/frame_guard.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "util/deadline.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kMaxUnusable = 32;
// Above the jitter: live cameras number by rounded time, with an error of at most half a period.
constexpr double kJumpPeriods = 0.6;

}  // namespace

FrameGuard::FrameGuard(std::unique_ptr<StereoCamera> camera, const FrameGuardConfig& config)
    : camera_(std::move(camera)), config_(config), timeline_(0, true) {}

Status FrameGuard::start() {
  own_ = {};
  begun_ = false;
  first_unusable_.reset();
  cut_off_ = {};
  timeline_ = TimelineGuard(std::llround(kJumpPeriods * period_ns()), true);
  return camera_->start();
}

bool FrameGuard::passes(const StereoFrame& frame) noexcept {
  const CameraInfo& announced = info();
  for (const bool is_left : {true, false}) {
    const GrayView image = is_left ? frame.left : frame.right;
    if (image.width != announced.width_px || image.height != announced.height_px) {
      ++own_.skipped_wrong_size;
      note_unusable({frame.frame_index, is_left, image.width, image.height, 0});
      return false;
    }
  }
  const bool is_new = !begun_ || frame.frame_index > last_index_;
  const bool advances = !begun_ || config_.mend_times || frame.timestamp_ns > last_time_ns_;
  if (!is_new || !advances) {
    ++own_.skipped_repeated;
    return false;
  }
  if (const auto cut_off = cut_off_.examine(frame)) {
    ++own_.skipped_unreadable;
    note_unusable({frame.frame_index, cut_off->is_left, announced.width_px, announced.height_px, cut_off->rows});
    return false;
  }
  return true;
}

void FrameGuard::note_unusable(const Unusable& unusable) noexcept {
  if (!first_unusable_) {
    first_unusable_ = unusable;
  }
}

// A stream that ends without a valid frame is an error with its reason.
Error FrameGuard::explain(Error end) const {
  if (end.code != ErrorCode::kEndOfStream || begun_ || !first_unusable_) {
    return end;
  }
  const Unusable& first = *first_unusable_;
  const std::string reason =
      first.missing_rows > 0
          ? concat("its lower ", std::to_string(first.missing_rows), " of ", std::to_string(first.height_px),
                   " rows are of one value, while the other view sees something there; was the lens covered or the "
                   "transfer cut off?")
          : concat("is ", size_text(first.width_px, first.height_px), " pixels, expected ",
                   size_text(info().width_px, info().height_px));
  return {ErrorCode::kBadFormat, concat(info().name, ": none of its frames can be used; the first: ",
                                        camera_->image_name(first.frame_index, first.is_left), ": ", reason)};
}

std::int64_t FrameGuard::expected_step_ns(const StereoFrame& frame) const noexcept {
  return std::llround(static_cast<double>(frame.frame_index - last_index_) * period_ns());
}

double FrameGuard::period_ns() const noexcept {
  constexpr double kMin_hz = 1e-3;
  return 1e9 / std::max(info().nominal_rate_hz, kMin_hz);
}

Result<StereoFrame> FrameGuard::next(std::chrono::milliseconds timeout) {
  const Deadline deadline(timeout);
  int unusable = 0;
  do {
    Result<StereoFrame> frame = camera_->next(deadline.left());
    if (!frame) {
      return Unexpected(explain(std::move(frame.error())));
    }
    if (!passes(*frame)) {
      ++unusable;
      continue;
    }
    if (config_.mend_times) {
      const std::int64_t expected_ns = expected_step_ns(*frame);
      // A camera may be faster than announced; numbering by time then counts each frame as a period.
      const std::int64_t shortest_ns = frame->frame_index == last_index_ + 1 ? 0 : expected_ns;
      const TimelineGuard::Step step = timeline_.correct(frame->timestamp_ns, {expected_ns, shortest_ns, expected_ns});
      own_.clock_jumps += step.jumped ? 1 : 0;
      frame->timestamp_ns = step.time_ns;
    }
    begun_ = true;
    last_index_ = frame->frame_index;
    last_time_ns_ = frame->timestamp_ns;
    return frame;
  } while (unusable < kMaxUnusable && !deadline.is_over());
  return fail(ErrorCode::kTimeout, concat(info().name, ": ", std::to_string(unusable),
                                          " frames in a row were repeated, cut off or of another size than ",
                                          size_text(info().width_px, info().height_px), "; check cable and settings"));
}

const CameraCounters& FrameGuard::counters() const noexcept {
  sum_ = camera_->counters();
  sum_.skipped_wrong_size += own_.skipped_wrong_size;
  sum_.skipped_repeated += own_.skipped_repeated;
  sum_.skipped_unreadable += own_.skipped_unreadable;
  sum_.clock_jumps += own_.clock_jumps;
  sum_.frames_delivered -= own_.skipped_wrong_size + own_.skipped_repeated + own_.skipped_unreadable;
  return sum_;
}

}  // namespace kinetrace::hal
