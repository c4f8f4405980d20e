// Buffers between modules within a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "kinetrace/tracking/prediction.hpp"
#include "window_refiner.hpp"

namespace kinetrace::pipeline {

struct FrameScratch {
  std::span<FeaturePrediction> predictions;                  ///< By feature slot.
  std::span<tracking::ObjectPrediction> object_predictions;  ///< By track slot.
  FixedVector<std::uint8_t> slots;                           ///< Of some tracks.
  std::span<BodyRefinement> refinements;  ///< The background's, then those of the objects that take part.

  FrameScratch(const PipelineConfig& config, Arena& arena)
      : predictions(arena.take<FeaturePrediction>(static_cast<std::size_t>(config.features.max_features))),
        object_predictions(
            arena.take<tracking::ObjectPrediction>(static_cast<std::size_t>(config.tracking.max_objects))),
        slots(arena, static_cast<std::size_t>(config.tracking.max_objects)),
        refinements(arena.take<BodyRefinement>(static_cast<std::size_t>(config.tracking.max_objects) + 1)) {}
};

}  // namespace kinetrace::pipeline
