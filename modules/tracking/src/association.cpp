// The part of StereoTracker that assigns detections to tracks.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "association_cost.hpp"
#include "expectations.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
namespace {

/// Standard deviations of an object's predicted position, relative to its size: without features, and with many.
constexpr double kPositionSigma = 0.15;
constexpr double kTrackedSigma = 0.03;
/// ... and for each second without a detection.
constexpr double kPositionSigmaPerSecond = 0.4;
constexpr double kMinPositionSigma_px = 1.0;
/// Number of features that halves the uncertainty of its motion.
constexpr double kFeaturesToHalveSigma = 4.0;
/// Log prior of features and prediction both being wrong, for an object detected in the previous frame.
constexpr double kLogPredictionFailure = -3.0;

/// Marks the sides that the image border cut off in `last`.
void mark_cut_sides(const PixelBox& last, int width_px, int height_px, BoxPrediction& prediction) {
  if (!last.empty()) {
    prediction.low_is_cut = {last.x0 <= 0, last.y0 <= 0};
    prediction.high_is_cut = {last.x1 >= width_px, last.y1 >= height_px};
  }
}

/// The same position, known to about a pixel.
BoxPrediction certain_box_at(const PixelBox& box, const Eigen::Vector2d& shift_px = Eigen::Vector2d::Zero()) {
  BoxPrediction prediction;
  prediction.low_px = Eigen::Vector2d(box.x0, box.y0) + shift_px;
  prediction.high_px = Eigen::Vector2d(box.x1, box.y1) + shift_px;
  const double size_px = (prediction.high_px - prediction.low_px).cwiseMax(1.0).prod();
  prediction.position_sigma_px.setConstant(kMinPositionSigma_px + kTrackedSigma * std::sqrt(size_px));
  prediction.size_sigma = kTrackedSigma;
  return prediction;
}

BoxPrediction box_at(const ImageExtent& extent, double occluded) {
  return {.low_px = extent.low_px,
          .high_px = extent.high_px,
          .low_sigma_px = extent.low_sigma_px,
          .high_sigma_px = extent.high_sigma_px,
          .occluded = occluded};
}

/// Whether the box says where the object's visible part is as surely as its mask does.
bool is_surer(const ImageExtent& extent, const BoxPrediction& mask) {
  return extent.low_sigma_px.cwiseMax(extent.high_sigma_px).maxCoeff() < mask.position_sigma_px.maxCoeff();
}

bool is_inside(const ImageExtent& extent, int width_px, int height_px) {
  return extent.low_px.minCoeff() >= 0.0 && extent.high_px.x() <= width_px && extent.high_px.y() <= height_px;
}

/// Size of a mask to which errors of its position are relative. The extent beyond the image border is unknown; the
/// longer side of the prediction stands for it.
Eigen::Vector2d reference_size_px(const BoxPrediction& mask, const PixelBox& last, int width_px, int height_px) {
  const Eigen::Vector2d extent_px = (mask.high_px - mask.low_px).cwiseMax(1.0);
  const double size_px = std::sqrt(extent_px.prod());
  const bool is_cut_across = !last.empty() && (last.x0 <= 0 || last.x1 >= width_px);
  const bool is_cut_along = !last.empty() && (last.y0 <= 0 || last.y1 >= height_px);
  return {is_cut_across ? extent_px.maxCoeff() : size_px, is_cut_along ? extent_px.maxCoeff() : size_px};
}

/// The predicted mask. `missed_s`: since its last detection, until the previous frame.
BoxPrediction mask_box(const TrackInstance& instance, double missed_s, int width_px, int height_px) {
  BoxPrediction mask;
  instance.mask.current_corners(mask.low_px, mask.high_px);
  mask.low_px.array() += 0.5;  // from the centre of a pixel to its edge
  mask.high_px.array() += 0.5;
  const double unknown_fraction = kFeaturesToHalveSigma / (kFeaturesToHalveSigma + instance.feature_votes.total);
  const double relative_sigma = kTrackedSigma + kPositionSigma * unknown_fraction + kPositionSigmaPerSecond * missed_s;
  const Eigen::Vector2d size_px = reference_size_px(mask, instance.track.box_px, width_px, height_px);
  mask.position_sigma_px = (relative_sigma * size_px).array() + kMinPositionSigma_px;
  mask.size_sigma = kTrackedSigma + kPositionSigma * unknown_fraction;
  return mask;
}

/// Disparity of the object: predicted, or else last measured.
struct ExpectedDisparity {
  double mean_px = 0.0;  ///< 0: not known.
  double sigma_px = 0.0;
};

ExpectedDisparity expected_disparity(const TrackInstance& instance) {
  if (instance.prediction.disparity_px > 0.0) {
    return {instance.prediction.disparity_px, instance.prediction.disparity_sigma_px};
  }
  return {instance.disparity.known ? double{instance.disparity.mean_px} : 0.0, 0.0};
}

}  // namespace

void StereoTracker::count_votes(LabelView detections, std::span<const Feature> features) noexcept {
  for (TrackInstance& instance : slots_) {
    instance.feature_votes = {};
  }
  if (detections.empty()) {
    return;
  }
  for (const Feature& feature : features) {
    const auto x = static_cast<int>(std::lround(feature.left_px.x()));
    const auto y = static_cast<int>(std::lround(feature.left_px.y()));
    const bool is_tracked = feature.age_frames > 0 && feature.body != kBackgroundLabel && feature.body <= slots_.size();
    if (is_tracked && detections.contains(x, y) && !lies_in_front(feature, slots_[feature.body - 1U].prediction)) {
      FeatureVotes& votes = slots_[feature.body - 1U].feature_votes;
      ++votes.total;
      ++votes.on_label[detections.at(x, y)];
    }
  }
}

double StereoTracker::position_evidence(const TrackInstance& instance, const Detection& detection) const noexcept {
  const auto evidence_at = [&](const BoxPrediction& expected) {
    return box_evidence(expected, detection.box_px, width_px_, height_px_);
  };
  const auto evidence_at_mask = [&](BoxPrediction expected) {
    mark_cut_sides(instance.track.box_px, width_px_, height_px_, expected);
    return evidence_at(expected);
  };
  // No known object occludes what is predicted outside the image.
  const double unoccluded =
      instance.predicted_px > 0 ? static_cast<double>(instance.overlap.area_px) / instance.predicted_px : 1.0;
  const double missed_s = 1e-9 * static_cast<double>(timestamp_ns_ - interval_ns_ - instance.matched_timestamp_ns);
  BoxPrediction mask = mask_box(instance, std::max(missed_s, 0.0), width_px_, height_px_);
  mask.occluded = 1.0 - unoccluded;
  double best = -std::numeric_limits<double>::infinity();
  // The mask lacks what the image border or an unknown occluder has hidden; the box has it.
  const std::optional<ImageExtent>& extent = instance.prediction.extent;
  if (extent) {
    best = std::max(best, evidence_at(box_at(*extent, mask.occluded)));
  }
  const bool may_use_mask = !extent || is_inside(*extent, width_px_, height_px_) || !is_surer(*extent, mask);
  if (may_use_mask && !is_behind_camera(instance)) {
    best = std::max(best, evidence_at_mask(mask));
  }
  if (instance.track.missed_frames == 0 && instance.track.age_frames > 0) {
    const ObjectPrediction& then = instance.previous_prediction;
    const ObjectPrediction& now = instance.prediction;
    const bool moved = then.known && now.known && then.direction_only == now.direction_only;
    const Eigen::Vector2d shift_px = moved ? Eigen::Vector2d(now.point_px - then.point_px) : Eigen::Vector2d(0.0, 0.0);
    best = std::max({best, kLogPredictionFailure + evidence_at_mask(certain_box_at(instance.track.box_px)),
                     kLogPredictionFailure + evidence_at_mask(certain_box_at(instance.track.box_px, shift_px))});
  }
  return best;
}

double StereoTracker::visible_fraction(const TrackInstance& instance) noexcept {
  return is_behind_camera(instance) || instance.predicted_px == 0
             ? 0.0
             : instance.mask_part_in_image * instance.overlap.area_px / instance.predicted_px;
}

double StereoTracker::overlap_fraction_with_others(const TrackInstance& instance,
                                                   const Detection& detection) const noexcept {
  int max_px = 0;
  for (const TrackInstance& other : slots_) {
    if (other.alive() && &other != &instance && classes_agree(other.track.class_id, detection.class_id)) {
      max_px = std::max(max_px, other.overlap.on_label[detection.label]);
    }
  }
  return static_cast<double>(max_px) / detection.area_px;
}

double StereoTracker::part_evidence(const TrackInstance& instance, const Detection& detection,
                                    std::span<const DisparitySample> samples) noexcept {
  const ObjectPrediction& prediction = instance.prediction;
  if (!prediction.volume || samples.empty()) {
    return -std::numeric_limits<double>::infinity();
  }
  return volume_evidence(*prediction.volume, samples) +
         (prediction.extent ? extent_evidence(*prediction.extent, detection.box_px) : 0.0);
}

double StereoTracker::place_evidence(const TrackInstance& instance, const Detection& detection, double disparity_px,
                                     std::span<const DisparitySample> samples) const noexcept {
  const ExpectedDisparity expected = expected_disparity(instance);
  const double as_predicted = position_evidence(instance, detection) +
                              disparity_evidence(expected.mean_px, expected.sigma_px, disparity_px, samples.size());
  return std::max(as_predicted, part_evidence(instance, detection, samples));
}

double StereoTracker::evidence(const TrackInstance& instance, const Detection& detection, double disparity_px,
                               std::span<const DisparitySample> samples) const noexcept {
  const FeatureVotes& votes = instance.feature_votes;
  const bool has_valid_features = !instance.missed.exceeds(kMaxFeatureGap_ns);
  return place_evidence(instance, detection, disparity_px, samples) + detection_evidence(visible_fraction(instance)) +
         (has_valid_features ? feature_evidence(votes.on_label[detection.label], votes.total) : 0.0) +
         (classes_agree(instance.track.class_id, detection.class_id) ? 0.0 : kOtherClassEvidence) -
         fragment_evidence(overlap_fraction_with_others(instance, detection));
}

void StereoTracker::associate(const DetectionFrame& detections, std::span<const Feature> features) noexcept {
  const LabelView labels = detections.available ? detections.left_labels : LabelView{};
  count_votes(labels, features);
  const std::size_t columns = detections.available ? detections.left.size() : 0;
  affinity_.resize(static_cast<int>(slots_.size()), static_cast<int>(columns));
  for (TrackInstance& instance : slots_) {
    instance.detection = -1;
    if (instance.alive()) {
      measure_overlap(prediction_, instance.track.label(), instance.mask.current_box(), labels, instance.overlap);
    }
  }
  for (std::size_t v = 0; v < columns; ++v) {
    const Detection& detection = detections.left[v];
    const std::span<const DisparitySample> samples = gather_samples(labels, detection.label, features);
    const double disparity_px = fit_disparity(samples, scratch_).mean_px;
    for (const TrackInstance& instance : slots_) {
      if (instance.alive() && is_assignable(instance)) {
        affinity_(instance.track.slot, static_cast<int>(v)) =
            std::max(0.0, evidence(instance, detection, disparity_px, samples));
      }
    }
  }
  apply_assignment(maximum_weight_assignment(affinity_), columns);
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    if (instance.detection >= 0) {
      accept_match(instance, detections.left[static_cast<std::size_t>(instance.detection)]);
    } else {
      accept_miss(instance, detections.has_looked_for(instance.overlap.box_px, instance.track.class_id));
    }
  }
}

void StereoTracker::apply_assignment(const Assignment& match, std::size_t columns) noexcept {
  owner_.clear();
  owner_.resize(columns);
  std::fill(owner_.begin(), owner_.end(), std::int16_t{-1});
  for (TrackInstance& instance : slots_) {
    if (instance.alive() && match[instance.track.slot] >= 0) {
      instance.detection = match[instance.track.slot];
      owner_[static_cast<std::size_t>(instance.detection)] = instance.track.slot;
    }
  }
}

}  // namespace kinetrace::tracking
