// The part of StereoTracker that matches detections beside where their tracks were expected.
#include <algorithm>
#include <cmath>

#include "expectations.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
namespace {

/// So many features that lie elsewhere, and hardly one on it, speak against a detection that is only near.
constexpr double kFewestElsewhere = 6.0;
constexpr double kHardlyOnIt = 0.1;
/// A detection may lie beside where its object was expected, by this part of the object's size,
constexpr double kReachOfSize = 0.5;
/// ... and so much more for each frame in which it has been missed,
constexpr double kReachPerFrame = 0.1;
constexpr double kMostReach_px = 20.0;
/// ... and be larger, or where all of it should be in sight smaller, than expected by this factor.
constexpr double kMostSizeRatio = 2.0;
/// Less of an object in sight is hidden: a detection may be any part of it that lies so far on the whole, or beside it.
constexpr double kMostlyHidden = 0.5;
constexpr double kLeastOnWhole = 0.5;
/// A detection that shows but a part of an object in sight lies so far on it, and is so large.
constexpr double kLeastPartOnIt = 0.2;
constexpr double kLeastSizeRatio = 0.15;
/// So far on what another track of its class expects, a detection is a part of that.
constexpr double kMostOnAnother = 0.3;

/// Between the nearest points of two boxes; 0 if they overlap.
double distance_between(const PixelBox& a, const PixelBox& b) noexcept {
  const int dx = std::max({a.x0 - b.x1, b.x0 - a.x1, 0});
  const int dy = std::max({a.y0 - b.y1, b.y0 - a.y1, 0});
  return std::hypot(dx, dy);
}

}  // namespace

bool StereoTracker::is_behind_camera(const TrackInstance& instance) noexcept {
  const Forecast& forecast = instance.forecast;
  return forecast.known && !forecast.direction_only && forecast.depth_m <= kMinForecastDepth_m;
}

bool StereoTracker::features_lie_elsewhere(const TrackInstance& instance, const Detection& detection) noexcept {
  const FeatureVotes& votes = instance.votes_of_features;
  return instance.track.missed_frames < kForeignAfterFrames && votes.total >= kFewestElsewhere &&
         votes.on_label[detection.label] < kHardlyOnIt * votes.total;
}

void StereoTracker::add_near_misses(const TrackInstance& instance, std::span<const Detection> detections) noexcept {
  if (is_behind_camera(instance)) {
    return;
  }
  for (std::size_t v = 0; v < detections.size(); ++v) {
    const Detection& detection = detections[v];
    const double gap_px = distance_between(instance.mask.current_box(), detection.box_px);
    if (owner_[v] < 0 && classes_agree(instance.track.class_id, detection.class_id) &&
        nearly_met(instance, detection, gap_px) && !features_lie_elsewhere(instance, detection) &&
        !lies_on_another(detection, instance)) {
      affinity_(instance.track.slot, static_cast<int>(v)) = part_on(instance, detection) + 1.0 / (1.0 + gap_px);
    }
  }
}

bool StereoTracker::nearly_met(const TrackInstance& instance, const Detection& detection, double gap_px) noexcept {
  const double whole_px = std::max(instance.predicted_px, 1);
  const double size_ratio = detection.area_px / whole_px;
  if (size_ratio > kMostSizeRatio) {
    return false;
  }
  const int missed = instance.track.missed_frames;
  // The longer it has not been seen, the less is known where it is.
  const double reach_px = std::min((kReachOfSize + kReachPerFrame * missed) * std::sqrt(whole_px), kMostReach_px);
  const double on_it = part_on(instance, detection);
  const bool whole_in_image = instance.mask_part_in_image >= kWholeInImage;
  if (instance.overlap.area_px < kMostlyHidden * whole_px) {
    return on_it >= kLeastOnWhole || (whole_in_image && gap_px <= reach_px);
  }
  const bool slipped = gap_px <= reach_px && size_ratio >= 1.0 / kMostSizeRatio && missed < kForeignAfterFrames &&
                       instance.mask_part_in_image >= kLeastVisiblePart;
  const bool cut_short = whole_in_image && on_it >= kLeastPartOnIt && size_ratio >= kLeastSizeRatio;
  return slipped || cut_short;
}

double StereoTracker::part_on(const TrackInstance& instance, const Detection& detection) noexcept {
  return static_cast<double>(instance.whole_on_label[detection.label]) / detection.area_px;
}

bool StereoTracker::lies_on_another(const Detection& detection, const TrackInstance& instance) const noexcept {
  return std::any_of(slots_.begin(), slots_.end(), [&](const TrackInstance& other) {
    return other.alive() && &other != &instance && classes_agree(other.track.class_id, detection.class_id) &&
           other.overlap.on_label[detection.label] > kMostOnAnother * detection.area_px;
  });
}

}  // namespace kinetrace::tracking
