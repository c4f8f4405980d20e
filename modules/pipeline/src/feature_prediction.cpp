#include "feature_prediction.hpp"

#include <algorithm>

namespace kinetrace::pipeline {
namespace {

/// Features of a body without motion yet, or of a moving object not yet segmented from the background: constant image
/// motion.
void predict_unexplained(std::span<const Feature> previous, const sfm::BodyReconstruction& background,
                         std::span<FeaturePrediction> by_slot) {
  for (const Feature& feature : previous) {
    const bool unexplained = feature.body == kBackgroundLabel && !background.agreed(feature);
    FeaturePrediction& prediction = by_slot[feature.slot];
    if (feature.age_frames > 0 && (unexplained || !prediction.known)) {
      prediction = {.left_px = 2.F * feature.left_px - feature.previous_left_px,
                    .disparity_px = feature.has_right() ? feature.disparity_px() : -1.F,
                    .known = true};
    }
  }
}

}  // namespace

void predict_features(std::span<const Feature> previous, const sfm::BodyReconstruction& background,
                      std::span<const ObjectState> objects, std::int64_t timestamp_ns,
                      std::span<FeaturePrediction> by_slot) {
  std::fill(by_slot.begin(), by_slot.end(), FeaturePrediction{});
  background.predict_features(previous, kBackgroundLabel, timestamp_ns, by_slot);
  for (const ObjectState& object : objects) {
    if (!object.in_use()) {
      continue;
    }
    // Until its motion is known, an object is assumed to be at rest in the world.
    const sfm::BodyReconstruction& body = object.body().history_size() < 2 ? background : object.body();
    body.predict_features(previous, object.track().label(), timestamp_ns, by_slot);
  }
  predict_unexplained(previous, background, by_slot);
}

}  // namespace kinetrace::pipeline
