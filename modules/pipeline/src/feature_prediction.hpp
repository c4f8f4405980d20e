// Where the features of the last frame are expected in the next one.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {

/// Each feature moves with its body; one that no body explains keeps its image motion. Writes `by_slot`, one entry for
/// each slot.
void predict_features(std::span<const Feature> previous, const sfm::BodyReconstruction& background,
                      std::span<const ObjectState> objects, std::int64_t timestamp_ns,
                      std::span<FeaturePrediction> by_slot);

}  // namespace kinetrace::pipeline
