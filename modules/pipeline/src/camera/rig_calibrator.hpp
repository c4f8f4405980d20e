// Refinement of the calibration as a stage of the pipeline.
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

/// Gives the front end the correction of the right image, and estimates it from features that agree with the camera's
/// pose. Does nothing where refinement is off.
class RigCalibrator {
 public:
  [[nodiscard]] static Result<RigCalibrator> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                    Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  /// Starts a frame with the newest correction.
  void begin_frame(std::int64_t timestamp_ns);
  [[nodiscard]] features::RigAdjustment adjustment() const;
  /// Conversion of measurements of earlier frames from now on; null if unchanged.
  [[nodiscard]] const RigChange* change() const noexcept { return change_ ? &*change_ : nullptr; }
  /// The measurement of points changes so much in this frame that reconstructions have to restart.
  [[nodiscard]] bool must_restart() const noexcept { return must_restart_; }
  /// Disparities change so much that earlier positions are no evidence of motion.
  [[nodiscard]] bool must_restart_paths() const noexcept { return must_restart_paths_; }
  /// The frame's features, once the camera is located. `is_cut`: there is a cut before this frame.
  void observe(const FeatureFrame& frame, const CameraTracker& camera, bool is_cut);

  /// Adds the uncertainty of the calibration to `camera`.
  void add_uncertainty(CameraState& camera) const;
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
