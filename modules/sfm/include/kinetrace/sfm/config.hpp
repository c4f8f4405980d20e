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
  int min_inliers = 8;            ///< Fewer agreeing points than this are no pose.
  double min_inlier_ratio = 0.4;  ///< A smaller part of agreeing points means: not rigid, or not this body.
  /// Points have a vote on the pose once so many frames have seen them and agreed; newer ones only while there are
  /// fewer than min_inliers of these. So what comes into view and moves by itself has no say, however much of the view
  /// it takes. Objects are found by their masks, and let all vote.
  int min_observations_for_consensus = 3;
  /// Standard deviation of u_left, v and u_right: at most, and before anything is known. What it is, is learnt from the
  /// residuals, but never taken to be less than the second.
  double measurement_sigma_px = 0.4;
  double min_measurement_sigma_px = 0.1;
  double gate_sigma = 4.0;         ///< Observations further off than this many sigmas (3-D) are outliers.
  int ransac_max_hypotheses = 96;  ///< Bound of the adaptive number of 3-point hypotheses.
  double min_disparity_px = 0.8;   ///< Points are made from stereo only above this disparity.
  double min_parallax_deg = 1.0;   ///< Points are made from temporal views only above this angle between rays.
  double keyframe_motion_px =
      8.0;  ///< A frame whose points moved less than this (median) since the last keyframe makes room for the next.
  double keyframe_overlap = 0.7;  ///< ... unless the last keyframe knows less than this part of its points.
  /// How fast the body usually turns in the world: bundle adjustment expects no more, and accepts more only where
  /// points show it. Far away, few points tell little of an attitude, and it drifts without this. 0: nothing is
  /// expected.
  double turn_rate_radps = 0.0;
  int reject_after_frames = 8;  ///< A feature that disagrees this often in a row is given back to the front end.

  [[nodiscard]] Status validate(const char* prefix) const;
};

}  // namespace kinetrace::sfm
