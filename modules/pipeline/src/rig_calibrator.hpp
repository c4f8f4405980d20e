// The calibration's refinement as part of a frame's way.
#pragma once

#include <cstddef>
#include <optional>

#include "camera_tracker.hpp"
#include "kinetrace/calibration/rig_refiner.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::pipeline {

/// Tells the front end how to understand the right image, and learns from what the camera's pose agrees with. Does
/// nothing where refinement is off.
class RigCalibrator {
 public:
  [[nodiscard]] static Result<RigCalibrator> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                    Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  /// A frame comes.
  void begin_frame(std::int64_t timestamp_ns);
  [[nodiscard]] features::RigAdjustment adjustment() const;
  /// Since this frame points are measured so differently that reconstructions have to begin anew.
  [[nodiscard]] bool has_changed() const noexcept { return has_changed_; }
  /// The frame's features, once the camera is located. `jumped`: it shows another scene than the one before.
  void observe(const FeatureFrame& frame, const CameraTracker& camera, bool jumped);

  [[nodiscard]] RigEstimate estimate() const { return refiner_ ? refiner_->estimate() : RigEstimate{}; }

 private:
  std::optional<calibration::RigRefiner> refiner_;
  FixedVector<calibration::RigObservation> observations_;
  bool corrects_ = false;
  bool has_changed_ = false;
};

}  // namespace kinetrace::pipeline
