// The part of StereoTracker that matches detections beside where their tracks were expected.
#include <algorithm>
#include <cmath>

#include "expectations.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
namespace {

/// So many features that lie elsewhere, and hardly one on it, speak against a detection that is only near.
constexpr double kMinElsewhere = 6.0;
constexpr double kHardlyOnIt = 0.1;
/// So many stereo features tell how far away a detection is.
constexpr std::size_t kMinTellingDepth = 3;
/// A detection may lie beside where its object was expected, by this part of the object's size,
constexpr double kReachOfSize = 0.5;
/// ... and so much more for each second since it was last detected,
constexpr double kReachPerSecond = 1.0;
constexpr double kMaxReach_px = 20.0;
/// ... and be larger, or where all of it should be in view smaller, than expected by this factor.
constexpr double kMaxSizeRatio = 2.0;
/// Less of an object in view is hidden: a detection may be any part of it that lies so far on the whole, or beside it.
constexpr double kMostlyHidden = 0.5;
constexpr double kMinOnWhole = 0.5;
/// A detection that shows but a part of an object in view lies so far on it, and is so large.
constexpr double kMinPartOnIt = 0.2;
constexpr double kMinSizeRatio = 0.15;
/// Of what is so far outside the image, the next to be seen is a strip along the border over which it comes,
constexpr double kMostlyOutside = 0.2;
constexpr int kMaxStrip_px = 25;
/// ... that lies beside it by this part of either.
constexpr double kMinBeside = 0.5;
/// So far on what another track of its class expects, a detection is a part of that.
constexpr double kMaxOnAnother = 0.3;

/// Where features say that it has gone, so much of its box or of the detection's is shared.
constexpr double kMinPartShared = 0.25;
/// A detection whose box shares so much with that of the last one, there or where the prediction has moved it to, shows
/// the same, wherever features or masks had it expected.
constexpr double kStillThere = 0.6;

/// Along one axis of the image, where a strip is seen and where an object is expected.
struct Extent {
  double strip_low = 0.0;
  double strip_high = 0.0;
  double expected_low = 0.0;
  double expected_high = 0.0;

  /// Of both; negative for a gap.
  [[nodiscard]] double overlap() const noexcept {
    return std::min(strip_high, expected_high) - std::max(strip_low, expected_low);
  }
  [[nodiscard]] bool passes_proximity_gate() const noexcept { return overlap() >= -kMaxReach_px; }
  /// Most of the strip, and of what can be seen of the object in an image of this size.
  [[nodiscard]] bool beside(int image_size) const noexcept {
    const double expected = std::min<double>(expected_high, image_size) - std::max(expected_low, 0.0);
    return overlap() >= kMinBeside * std::max(strip_high - strip_low, expected);
  }
};

/// Pixels that two boxes share, the first of them moved.
double shared_px(const PixelBox& a, const Eigen::Vector2d& moved_px, const PixelBox& b) noexcept {
  const double x = moved_px.x();
  const double y = moved_px.y();
  const double width = std::min<double>(a.x1 + x, b.x1) - std::max<double>(a.x0 + x, b.x0);
  const double height = std::min<double>(a.y1 + y, b.y1) - std::max<double>(a.y0 + y, b.y0);
  return width > 0.0 && height > 0.0 ? width * height : 0.0;
}

double area_px(const PixelBox& box) noexcept {
  return static_cast<double>(box.width()) * box.height();
}

/// Of two boxes, the first of them moved.
double intersection_over_union(const PixelBox& a, const Eigen::Vector2d& moved_px, const PixelBox& b) noexcept {
  const double shared = shared_px(a, moved_px, b);
  return shared > 0.0 ? shared / (area_px(a) + area_px(b) - shared) : 0.0;
}

/// Of two intervals.
double intersection_over_union(int low_a, int high_a, int low_b, int high_b) noexcept {
  const int shared = std::min(high_a, high_b) - std::max(low_a, low_b);
  return static_cast<double>(shared) / (std::max(high_a, high_b) - std::min(low_a, low_b));
}

/// Of the smaller box, on the other.
double part_shared(const PixelBox& a, const PixelBox& b) noexcept {
  const double shared = shared_px(a, Eigen::Vector2d::Zero(), b);
  return shared > 0.0 ? shared / std::min(area_px(a), area_px(b)) : 0.0;
}

/// Between the nearest points of two boxes; 0 if they overlap.
double distance_between(const PixelBox& a, const PixelBox& b) noexcept {
  const int dx = std::max({a.x0 - b.x1, b.x0 - a.x1, 0});
  const int dy = std::max({a.y0 - b.y1, b.y0 - a.y1, 0});
  return std::hypot(dx, dy);
}

}  // namespace

bool StereoTracker::reaches_over_border(const TrackInstance& instance, const Detection& detection) const noexcept {
  if (instance.mask_part_in_image > kMostlyOutside) {
    return false;
  }
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  instance.mask.current_corners(low, high);
  const PixelBox& strip = detection.box_px;
  const bool at_side = (strip.x0 == 0 && low.x() < 0.0) || (strip.x1 == width_px_ && high.x() > width_px_);
  const bool at_end = (strip.y0 == 0 && low.y() < 0.0) || (strip.y1 == height_px_ && high.y() > height_px_);
  const Extent columns{static_cast<double>(strip.x0), static_cast<double>(strip.x1), low.x(), high.x()};
  const Extent rows{static_cast<double>(strip.y0), static_cast<double>(strip.y1), low.y(), high.y()};
  return (at_side && strip.width() <= kMaxStrip_px && columns.passes_proximity_gate() && rows.beside(height_px_)) ||
         (at_end && strip.height() <= kMaxStrip_px && rows.passes_proximity_gate() && columns.beside(width_px_));
}

bool StereoTracker::is_behind_camera(const TrackInstance& instance) noexcept {
  const ObjectPrediction& prediction = instance.prediction;
  return prediction.known && !prediction.direction_only && prediction.depth_m <= kMinPredictionDepth_m;
}

bool StereoTracker::features_lie_elsewhere(const TrackInstance& instance, const Detection& detection) noexcept {
  const FeatureVotes& votes = instance.votes_of_features;
  return !instance.missed.exceeds(kForeignAfter_ns) && votes.total >= kMinElsewhere &&
         votes.on_label[detection.label] < kHardlyOnIt * votes.total;
}

bool StereoTracker::lies_at_another_depth(const TrackInstance& instance,
                                          std::span<const DisparitySample> seen) noexcept {
  if (!instance.disparity.known || seen.size() < kMinTellingDepth) {
    return false;
  }
  const float seen_px = fit_disparity(seen, scratch_).mean_px;
  return clearly_nearer(seen_px, instance.disparity.mean_px) || clearly_nearer(instance.disparity.mean_px, seen_px);
}

void StereoTracker::add_proximity_pairs(const TrackInstance& instance, const DetectionFrame& detections,
                                        std::span<const Feature> features) noexcept {
  if (is_behind_camera(instance)) {
    return;
  }
  for (std::size_t v = 0; v < owner_.size(); ++v) {
    const Detection& detection = detections.left[v];
    const double gap_px = distance_between(instance.mask.current_box(), detection.box_px);
    if (owner_[v] < 0 && classes_agree(instance.track.class_id, detection.class_id) &&
        (passes_proximity_gate(instance, detection, gap_px) || still_there(instance, detection) ||
         reaches_over_border(instance, detection)) &&
        !features_lie_elsewhere(instance, detection) && !lies_on_another(detection, instance) &&
        !lies_at_another_depth(instance, gather_samples(detections.left_labels, detection.label, features))) {
      affinity_(instance.track.slot, static_cast<int>(v)) = part_on(instance, detection) + 1.0 / (1.0 + gap_px);
    }
  }
}

bool StereoTracker::still_there(const TrackInstance& instance, const Detection& detection) const noexcept {
  if (instance.track.missed_frames > 0) {
    return false;
  }
  const ObjectPrediction& then = instance.previous_prediction;
  const ObjectPrediction& now = instance.prediction;
  const bool moved = then.known && now.known && then.direction_only == now.direction_only;
  const Eigen::Vector2d shift_px = moved ? Eigen::Vector2d(now.point_px - then.point_px) : Eigen::Vector2d(0.0, 0.0);
  const PixelBox& box = instance.track.box_px;
  return comes_further_in(box, detection.box_px) ||
         intersection_over_union(box, Eigen::Vector2d::Zero(), detection.box_px) >= kStillThere ||
         intersection_over_union(box, shift_px, detection.box_px) >= kStillThere;
}

bool StereoTracker::comes_further_in(const PixelBox& box, const PixelBox& seen) const noexcept {
  const bool same_rows = intersection_over_union(box.y0, box.y1, seen.y0, seen.y1) >= kStillThere;
  const bool same_columns = intersection_over_union(box.x0, box.x1, seen.x0, seen.x1) >= kStillThere;
  const bool left = box.x0 == 0 && seen.x0 == 0 && std::abs(seen.x1 - box.x1) <= kMaxReach_px;
  const bool right = box.x1 == width_px_ && seen.x1 == width_px_ && std::abs(seen.x0 - box.x0) <= kMaxReach_px;
  const bool top = box.y0 == 0 && seen.y0 == 0 && std::abs(seen.y1 - box.y1) <= kMaxReach_px;
  const bool bottom = box.y1 == height_px_ && seen.y1 == height_px_ && std::abs(seen.y0 - box.y0) <= kMaxReach_px;
  return (same_rows && (left || right)) || (same_columns && (top || bottom));
}

bool StereoTracker::passes_proximity_gate(const TrackInstance& instance, const Detection& detection,
                                          double gap_px) const noexcept {
  const double whole_px = std::max(instance.predicted_px, 1);
  const double size_ratio = detection.area_px / whole_px;
  if (size_ratio > kMaxSizeRatio) {
    return false;
  }
  // The longer it has not been seen, the less is known where it is. As long as it was not by the frame before.
  const double missed_s = 1e-9 * static_cast<double>(timestamp_ns_ - interval_ns_ - instance.matched_timestamp_ns);
  const double reach_px = std::min((kReachOfSize + kReachPerSecond * missed_s) * std::sqrt(whole_px), kMaxReach_px);
  const double on_it = part_on(instance, detection);
  const bool whole_in_image = instance.mask_part_in_image >= kWholeInImage;
  if (instance.overlap.area_px < kMostlyHidden * whole_px) {
    return on_it >= kMinOnWhole || (whole_in_image && gap_px <= reach_px);
  }
  // Features that have gone astray take it no farther than so.
  const bool may_slip =
      !instance.motion_from_flow || part_shared(instance.mask.current_box(), detection.box_px) >= kMinPartShared;
  const bool slipped = may_slip && gap_px <= reach_px && size_ratio >= 1.0 / kMaxSizeRatio &&
                       !instance.missed.exceeds(kForeignAfter_ns) && instance.mask_part_in_image >= kMinVisiblePart;
  const bool cut_short = whole_in_image && on_it >= kMinPartOnIt && size_ratio >= kMinSizeRatio;
  return slipped || cut_short;
}

double StereoTracker::part_on(const TrackInstance& instance, const Detection& detection) noexcept {
  return static_cast<double>(instance.whole_on_label[detection.label]) / detection.area_px;
}

bool StereoTracker::lies_on_another(const Detection& detection, const TrackInstance& instance) const noexcept {
  return std::any_of(slots_.begin(), slots_.end(), [&](const TrackInstance& other) {
    return other.alive() && &other != &instance && classes_agree(other.track.class_id, detection.class_id) &&
           other.overlap.on_label[detection.label] > kMaxOnAnother * detection.area_px;
  });
}

}  // namespace kinetrace::tracking
