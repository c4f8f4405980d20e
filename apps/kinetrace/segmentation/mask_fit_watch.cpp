#include "segmentation/mask_fit_watch.hpp"

#include <cmath>
#include <utility>

namespace kinetrace::app {
namespace {

constexpr double kMemory_ns = 2e9;
// Both sides of an object 400 px tall, or of one of 40 px in ten frames: fewer show the contrast of one object.
constexpr int kMinPoints = 800;
// Over 78 rendered recordings, good masks had a ratio to their surroundings of at least 1.33 in every frame (2.1 in the
// median), masks of another recording 1.2 in the median, and masks of the other view 1.4 to 2 on that view.
constexpr double kMinContrast = 1.2;
constexpr double kSureContrast = 1.5;
// Good masks had at most .96 times their contrast on the other view, masks of the other view at least 1.05.
constexpr double kMinExchanged = 1.05;

}  // namespace

Status MaskFitWatch::process(const FrameResult& result, HealthMonitor& health, const Warn& warn) {
  const std::uint64_t missing = std::exchange(frames_missing_, result.counters.detection_frames_missing);
  if (missing != frames_missing_) {
    return {};
  }
  add(result);
  const std::optional<Fault> fault = assess();
  if (!fault || (reported_ && reported_ != fault)) {
    return {};
  }
  const bool exchanged = fault == Fault::kExchanged;
  health.note(exchanged ? HealthReason::kMasksExchanged : HealthReason::kMasksUnrelated);
  if (std::exchange(reported_, fault)) {
    return {};
  }
  if (!exchanged) {
    warn(source_ +
         ": the masks' outlines lie where the images have no edges; the masks belong to other images, or are more than "
         "3 px off: give those of the rectified left images of this recording");
    return {};
  }
  const std::string what =
      source_ + ": the masks fit the right images, not the left ones; exchange the two views' masks";
  if (policy_ == InputPolicy::kStop) {
    return fail(ErrorCode::kBadFormat, what + " (input.unusable: warn continues)");
  }
  warn(what);
  return {};
}

void MaskFitWatch::add(const FrameResult& result) noexcept {
  const std::int64_t now_ns = result.newest.timestamp_ns;
  const auto elapsed_ns = static_cast<double>(now_ns - std::exchange(last_ns_, now_ns));
  recent_ *= std::exp(-elapsed_ns / kMemory_ns);
  recent_ += segmentation::outline_contrast(result.pair, result.left_labels, result.tracks);
}

std::optional<MaskFitWatch::Fault> MaskFitWatch::assess() const noexcept {
  if (recent_.points < kMinPoints) {
    return std::nullopt;
  }
  if (recent_.right > kMinExchanged * recent_.left && recent_.right > kSureContrast * recent_.beside) {
    return Fault::kExchanged;
  }
  return recent_.left < kMinContrast * recent_.beside ? std::optional(Fault::kUnrelated) : std::nullopt;
}

}  // namespace kinetrace::app
