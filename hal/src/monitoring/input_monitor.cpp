#include "kinetrace/hal/input_monitor.hpp"

#include <algorithm>

namespace kinetrace::hal {
namespace {

// Noise of half a grey level changes a pixel in at least a third of the frames: a thousand pixels are never equal by
// chance. Three frames tolerate a driver that delivers one image twice.
constexpr int kEqualFrames = 3;
// Fewer matches in a grid of 64 are seldom consistent.
constexpr int kMinMatches = 12;
// Part of the matches that must agree.
constexpr double kMinAgreeingShare = 0.9;
// Part above that of mismatches on repeated texture.
constexpr double kMinNegativeShare = 0.25;
constexpr double kRowsApart_px = 1.0;
// Larger yaw errors are not those of a calibration: more negative disparities mean exchanged views.
constexpr double kMaxYaw_rad = 0.0087;  // Half a degree.
// Of patches with texture: at least a quarter match in good pairs, one in thirty by chance.
constexpr int kMinSearchedPatches = 32;  // Half of all.
constexpr double kMaxUnrelatedShare = 0.1;

}  // namespace

void ImageSample::take(GrayView image) noexcept {
  constexpr int kMinContrast = 8;
  auto value = values_.begin();
  for (int row = 0; row < kRows; ++row) {
    const std::uint8_t* pixels = image.row((2 * row + 1) * image.height / (2 * kRows));
    for (int column = 0; column < kColumns; ++column) {
      *value++ = pixels[(2 * column + 1) * image.width / (2 * kColumns)];
    }
  }
  const auto [darkest, brightest] = std::minmax_element(values_.begin(), values_.end());
  has_texture_ = *brightest - *darkest >= kMinContrast;
}

void FaultVotes::cast(bool faulty) noexcept {
  faulty_[count_++ % kVotes] = faulty;
}

bool FaultVotes::hold() const noexcept {
  const std::size_t faulty = faulty_.count();
  return faulty >= kMin && 4 * faulty >= 3 * std::min(count_, kVotes);
}

Result<InputMonitor> InputMonitor::create(const SyncMonitorConfig& config, int width_px, int height_px, Arena& arena) {
  const Result<SyncMonitor> sync = SyncMonitor::create(config, width_px, height_px, arena);
  if (!sync) {
    return Unexpected(sync.error());
  }
  return InputMonitor(*sync);
}

bool InputMonitor::process(const StereoFrame& frame, const RectifiedPair& pair) noexcept {
  sample(frame);
  if (!sync_.process(pair)) {
    return false;
  }
  assess(sync_.report(), pair.geometry.fx_px);
  return true;
}

void InputMonitor::View::see(const ImageSample& now) noexcept {
  unchanged = begun && now.has_texture() && now == last ? unchanged + 1 : 0;
  begun = true;
  last = now;
}

void InputMonitor::sample(const StereoFrame& frame) noexcept {
  ImageSample left;
  ImageSample right;
  left.take(frame.left);
  right.take(frame.right);
  identical_ = left.has_texture() && left == right ? identical_ + 1 : 0;
  left_.see(left);
  right_.see(right);
  set(InputFault::kViewsIdentical, identical_ >= kEqualFrames);
  set(InputFault::kLeftFrozen, left_.unchanged >= kEqualFrames);
  set(InputFault::kRightFrozen, right_.unchanged >= kEqualFrames);
}

void InputMonitor::assess(const SyncReport& report, double focal_px) noexcept {
  set(InputFault::kViewsOutOfStep,
      report.verdict == SyncVerdict::kRightLate || report.verdict == SyncVerdict::kRightEarly);
  if (report.searched >= kMinSearchedPatches) {
    vote(InputFault::kViewsUnrelated, report.matches < kMaxUnrelatedShare * report.searched);
  }
  if (report.matches < kMinMatches) {
    return;
  }
  const double all = report.matches;
  const int shifted = report.in_front + report.beyond_infinity;
  vote(InputFault::kNoParallax, shifted < (1.0 - kMinAgreeingShare) * all);
  const bool exchanged = report.beyond_infinity >= kMinMatches &&
                         report.beyond_infinity > kMinAgreeingShare * shifted &&
                         report.disparity_px < -kMaxYaw_rad * focal_px;
  vote(InputFault::kViewsExchanged, exchanged);
  vote(InputFault::kBeyondInfinity, !exchanged && report.beyond_infinity > kMinNegativeShare * all);
  // Rows also differ if a view is late.
  if (report.latest == SyncVerdict::kInStep || report.latest == SyncVerdict::kUnknown) {
    vote(InputFault::kRowsApart, report.residual_px > kRowsApart_px);
  }
}

void InputMonitor::vote(InputFault fault, bool faulty) noexcept {
  FaultVotes& votes = votes_[static_cast<std::size_t>(fault)];
  votes.cast(faulty);
  set(fault, votes.hold());
}

}  // namespace kinetrace::hal
