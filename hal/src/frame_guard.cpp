#include "kinetrace/hal/frame_guard.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "deadline.hpp"
#include "messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kMaxUnusable = 32;
// Jitter is no jump. Live cameras number by time, rounded: theirs is at most half a period.
constexpr double kJumpPeriods = 0.6;
constexpr int kRowsLookedAt = 24;
constexpr int kPixelsLookedAt = 16;
constexpr int kLeastContrast = 12;  // Several times the noise of a saturated or black row.

// Darkest and brightest of the pixels looked at.
struct Range {
  int lowest = 255;
  int highest = 0;
};

Range range_of(GrayView image, int place) noexcept {
  const std::uint8_t* row = image.row((2 * place + 1) * image.height / (2 * kRowsLookedAt));
  const int step = std::max(1, image.width / kPixelsLookedAt);
  Range range;
  for (int x = 0; x < image.width; x += step) {
    range.lowest = std::min<int>(range.lowest, row[x]);
    range.highest = std::max<int>(range.highest, row[x]);
  }
  return range;
}

// What did not arrive is the end of the image, and of one value throughout. A sky or a night may be so as well, but
// then the other eye sees next to nothing there either.
int missing_rows(GrayView image, GrayView other) noexcept {
  const int filling = range_of(image, kRowsLookedAt - 1).lowest;
  int missing = 0;
  for (int place = kRowsLookedAt - 1; place >= 0; --place) {
    const Range here = range_of(image, place);
    if (here.lowest != filling || here.highest != filling) {
      break;
    }
    const Range there = range_of(other, place);
    missing += there.highest - there.lowest >= kLeastContrast ? 1 : 0;
  }
  return missing;
}

}  // namespace

bool looks_cut_off(const StereoFrame& frame) noexcept {
  return std::max(missing_rows(frame.left, frame.right), missing_rows(frame.right, frame.left)) >= kRowsLookedAt / 3;
}

FrameGuard::FrameGuard(std::unique_ptr<StereoCamera> camera, const FrameGuardConfig& config)
    : camera_(std::move(camera)), config_(config), timeline_(0, true) {}

Status FrameGuard::start() {
  own_ = {};
  begun_ = false;
  timeline_ = TimelineGuard(std::llround(kJumpPeriods * period_ns()), true);
  return camera_->start();
}

bool FrameGuard::passes(const StereoFrame& frame) noexcept {
  const CameraInfo& announced = info();
  for (const GrayView& image : {frame.left, frame.right}) {
    if (image.width != announced.width_px || image.height != announced.height_px) {
      ++own_.skipped_wrong_size;
      return false;
    }
  }
  const bool is_new = !begun_ || frame.frame_index > last_index_;
  const bool advances = !begun_ || config_.mend_times || frame.timestamp_ns > last_time_ns_;
  if (!is_new || !advances) {
    ++own_.skipped_repeated;
    return false;
  }
  if (looks_cut_off(frame)) {
    ++own_.skipped_unreadable;
    return false;
  }
  return true;
}

std::int64_t FrameGuard::expected_step_ns(const StereoFrame& frame) const noexcept {
  return std::llround(static_cast<double>(frame.frame_index - last_index_) * period_ns());
}

double FrameGuard::period_ns() const noexcept {
  constexpr double kLowest_hz = 1e-3;
  return 1e9 / std::max(info().nominal_rate_hz, kLowest_hz);
}

Result<StereoFrame> FrameGuard::next(std::chrono::milliseconds timeout) {
  const Deadline deadline(timeout);
  int unusable = 0;
  do {
    Result<StereoFrame> frame = camera_->next(deadline.left());
    if (!frame) {
      return frame;
    }
    if (!passes(*frame)) {
      ++unusable;
      continue;
    }
    if (config_.mend_times) {
      const std::int64_t expected_ns = expected_step_ns(*frame);
      // A camera may be faster than announced, and one numbered by time then counts each frame as a period.
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
