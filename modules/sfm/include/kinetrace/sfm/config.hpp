// Settings of the reconstruction of one body.
#pragma once

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::sfm {

/// Sizes and gates of one body's mini-SfM. Background and objects use the same settings type with other sizes.
struct KINETRACE_API BodyConfig {
  int max_features = 1600;  ///< Slots of the feature front end.
  int max_points = 700;     ///< Points of the map; beyond, new points are dropped and counted.
  /// Frames that bundle adjustment refines; also the lag after which a pose is finalised. One: single-frame stereo,
  /// each point where the newest frame alone sees it, nothing to refine.
  int window_frames = 10;
  int min_inliers = 8;            ///< Least number of inliers of a pose.
  double min_inlier_ratio = 0.4;  ///< Below this ratio the body is not rigid, or another one.
  /// Only points observed and in agreement in so many frames select the pose; newer ones only while there are fewer
  /// than five of these. So a moving object that comes into view does not affect the pose, however large it is. Objects
  /// are located by their masks, and let all points take part.
  int min_observations_for_consensus = 3;
  /// Standard deviation of u_left, v and u_right: upper bound and initial value. The actual one is estimated from the
  /// residuals, with the second as lower bound.
  double measurement_sigma_px = 0.4;
  double min_measurement_sigma_px = 0.1;
  double gate_sigma = 4.0;         ///< Observations with a larger residual, in sigmas (3-D), are outliers.
  int ransac_max_hypotheses = 96;  ///< Bound of the adaptive number of 3-point hypotheses.
  double min_disparity_px = 0.8;   ///< Least disparity of points created from stereo.
  double min_parallax_deg = 1.0;   ///< Least angle between rays of points created from temporal views.
  double keyframe_motion_px =
      8.0;  ///< A frame whose points moved less than this (median) since the last keyframe makes room for the next.
  double keyframe_overlap = 0.7;  ///< ... unless the last keyframe knows less than this part of its points.
  /// Usual turn rate of the body in the world: a prior of bundle adjustment with a robust loss. The few points of a
  /// distant body say little about its attitude, which drifts without this prior. 0: no prior.
  double turn_rate_radps = 0.0;
  int reject_after_frames = 8;  ///< A feature that disagrees in so many successive frames is returned to the front end.

  [[nodiscard]] Status validate(const char* prefix) const;
};

}  // namespace kinetrace::sfm
