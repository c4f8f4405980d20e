// The calibration's refinement as part of a frame's way.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "camera/camera_tracker.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "kinetrace/rig/rig_refiner.hpp"

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
  /// How what was measured in earlier frames is to be understood from now on; null where that is as before.
  [[nodiscard]] const RigChange* change() const noexcept { return change_ ? &*change_ : nullptr; }
  /// Points are measured so differently since this frame that reconstructions have to begin anew.
  [[nodiscard]] bool must_restart() const noexcept { return must_restart_; }
  /// Disparities are: positions from before say nothing about motion.
  [[nodiscard]] bool must_restart_paths() const noexcept { return must_restart_paths_; }
  /// The frame's features, once the camera is located. `jumped`: it shows another scene than the one before.
  void observe(const FeatureFrame& frame, const CameraTracker& camera, bool jumped);

  /// What is in doubt about the calibration, for what is composed with the camera.
  void describe(CameraState& camera) const;
  [[nodiscard]] RigEstimate estimate() const { return refiner_ ? refiner_->estimate() : RigEstimate{}; }

 private:
  StereoGeometry geometry_;
  std::optional<rig::RigRefiner> refiner_;
  FixedVector<rig::RigObservation> observations_;
  bool corrects_ = false;
  std::span<float> scratch_px_;
  double background_disparity_px_ = 0.0;
  std::optional<RigChange> change_;
  bool must_restart_ = false;
  bool must_restart_paths_ = false;
};

}  // namespace kinetrace::pipeline
