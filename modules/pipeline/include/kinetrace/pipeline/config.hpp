// All settings of the pipeline, and one table that names them.
#pragma once

#include <array>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/features/feature_config.hpp"
#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"
#include "kinetrace/rig/config.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "kinetrace/sfm/config.hpp"
#include "kinetrace/tracking/config.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::pipeline {

/// Sizes of an object's reconstruction: few points, a window as long as the background's.
[[nodiscard]] constexpr sfm::BodyConfig default_object_config() noexcept {
  sfm::BodyConfig config;
  config.min_observations_for_consensus = 0;
  config.max_points = 160;
  config.keyframe_motion_px = 2.0;  // A turning object shows new sides long before it has moved far in the image.
  config.gate_sigma = 3.0;
  config.turn_rate_radps = 0.1;
  return config;
}

struct MemoryConfig {
  double budget_mib = 0.0;      ///< Of the whole process at its peak; a larger plan is refused. 0: what the plan needs.
  double libraries_mib = 21.0;  ///< Set aside for code and libraries.
};

/// Reconstruction of objects from tracks.
struct ObjectConfig {
  int stereo_only_min_features = 2;  ///< Stereo features that give an object too small for SfM its position.
  double lost_after_s = 1.0;         ///< An object that is predicted for longer counts as lost.
  bool rigid_pedestrians = false;    ///< Reconstruct people too; off, they get a trajectory from stereo.
};

/// Everything that decides what a run computes. `max_features` and the object count are set once, in `features` and
/// `tracking`; the reconstructions follow.
struct KINETRACE_API PipelineConfig {
  rig::RefineConfig calibration;
  features::FeatureConfig features;
  /// Replaces features.bucket_px while objects are found by motion, which needs features on them beforehand.
  int motion_bucket_px = 16;
  segmentation::SegmentationConfig segmentation;
  tracking::TrackerConfig tracking;
  sfm::BodyConfig background;
  sfm::BodyConfig object = default_object_config();
  refinement::FixedBundleConfig refinement;
  ObjectConfig objects;
  trajectory::TrajectoryConfig trajectory;
  MemoryConfig memory;

  /// kInvalidConfig naming the first key that is out of range.
  [[nodiscard]] Status validate() const;
};

namespace detail {

template <typename Body, typename Visitor>
void visit_body(Body& body, Visitor& visit, const std::array<std::string_view, 12>& keys) {
  visit(keys[0], body.max_points,
        "maximum number of map points; beyond, those unseen for longest make room, then new points are dropped");
  visit(keys[1], body.window_frames, "frames that bundle adjustment refines; also the lag after which a pose is final");
  visit(keys[2], body.min_inliers, "minimum number of agreeing points of a pose");
  visit(keys[3], body.min_inlier_ratio, "minimum part of points that agree on a pose");
  visit(keys[4], body.measurement_sigma_px,
        "maximum standard deviation of u_left, v and u_right, px; the actual one is learnt");
  visit(keys[5], body.min_measurement_sigma_px, "minimum standard deviation of u_left, v and u_right, px");
  visit(keys[6], body.gate_sigma, "deviation beyond which an observation is an outlier, in standard deviations");
  visit(keys[7], body.ransac_max_hypotheses, "maximum number of 3-point hypotheses; their number is adaptive");
  visit(keys[8], body.min_disparity_px, "minimum disparity of a point made from stereo, px");
  visit(keys[9], body.min_parallax_deg, "minimum angle between the rays of a point made from temporal views, degrees");
  visit(keys[10], body.keyframe_motion_px,
        "minimum motion of points since the last keyframe with which a frame is kept, px");
  visit(keys[11], body.keyframe_overlap,
        "part of a frame's points that the last keyframe must have seen, or else the frame is kept");
}

template <typename Config, typename Visitor>
void visit_calibration(Config& config, Visitor& visit) {
  auto& c = config.calibration;
  visit("calibration.refine", c.mode,
        "on (the right camera's pose is estimated, significant errors are corrected), check (errors are only reported) "
        "or off");
  visit("calibration.max_points", c.max_points, "background points in each estimate");
  visit("calibration.prior_sigma_deg", c.prior_sigma_deg, "standard deviation of the calibration's angles, degrees");
  visit("calibration.bias_px", c.bias_px, "matching error that does not average out, px");
}

template <typename Config, typename Visitor>
void visit_features(Config& config, Visitor& visit) {
  auto& f = config.features;
  visit("features.max_features", f.max_features, "number of feature slots over all bodies");
  visit("features.max_background_features", f.max_background_features, "maximum number of background features");
  visit("features.max_features_per_object", f.max_features_per_object, "maximum number of features of one object");
  visit("features.pyramid_levels", f.pyramid_levels,
        "number of image pyramid levels, each half the size of the one before");
  visit("features.bucket_px", f.bucket_px, "bucket size of background features, px; one new feature per free bucket");
  visit("features.motion_bucket_px", config.motion_bucket_px,
        "bucket size of background features while objects are found by motion, px");
  visit("features.object_bucket_px", f.object_bucket_px, "bucket size of object features, px");
  visit("features.min_distance_px", f.min_distance_px,
        "minimum distance between a new corner and any live feature, px");
  visit("features.min_corner_strength", f.min_corner_strength,
        "minimum root of the smaller gradient eigenvalue of a corner, gray per px");
  visit("features.min_object_corner_strength", f.min_object_corner_strength,
        "minimum root of the smaller gradient eigenvalue of a corner on an object, gray per px");
  visit("features.forward_backward_px", f.forward_backward_px,
        "maximum distance from the start after tracking there and back, px");
  visit("features.min_correlation", f.min_correlation, "minimum correlation of a patch with its match");
  visit("features.max_residual", f.max_residual, "maximum RMS gray difference of a match whose correlation is lower");
  visit("features.min_patch_strength", f.min_patch_strength, "minimum texture of a patch that is tracked, gray per px");
  visit("features.refine_against_reference", f.refine_against_reference,
        "alignment with the patch as first seen, against drift");
  visit("features.max_disparity_px", f.max_disparity_px,
        "left-right search range, px: the nearest distance is fx baseline / this");
  visit("features.min_disparity_px", f.min_disparity_px, "minimum disparity of a left-right match, px");
  visit("features.max_row_difference_px", f.max_row_difference_px, "maximum row difference of a left-right match, px");
  visit("features.uniqueness_ratio", f.uniqueness_ratio,
        "minimum ratio of second-best to best cost of a left-right match");
  visit("features.mask_border_px", f.mask_border_px,
        "distance from a mask border within which a feature keeps its body, px");
}

template <typename Config, typename Visitor>
void visit_segmentation(Config& config, Visitor& visit) {
  auto& s = config.segmentation;
  visit("segmentation.mode", s.mode,
        "auto (motion, and a network where there is one), motion, none (no objects), masks (files), onnx (a network) "
        "or dds (another process)");
  visit("segmentation.left_dir", s.left_dir,
        "folder of left masks for mode masks; files are named like the left images");
  visit("segmentation.right_dir", s.right_dir, "folder of right masks for mode masks; empty: none");
  visit("segmentation.max_objects", s.max_objects, "maximum number of instances per frame; the largest stay");
  visit("segmentation.min_area_px", s.min_area_px, "minimum area of an instance, pixels");
  visit("segmentation.dds.timeout_ms", s.dds.timeout_ms,
        "maximum time that a frame waits for masks of another process, ms; then tracks are propagated");
  visit("segmentation.dds.right", s.dds.right, "request for masks of the right image, too");
  visit("segmentation.onnx.model", s.onnx.model,
        "YAML file that describes the network; empty: the one that comes with Kinetrace, for simulated pictures");
  visit(
      "segmentation.onnx.latency_frames", s.onnx.latency_frames,
      "frames after which the network's masks are used and it gets the next frame; 0: each frame waits for its masks");
  visit("segmentation.onnx.threads", s.onnx.threads, "number of threads of the network, beside those of tracking");
  visit("segmentation.onnx.right", s.onnx.right,
        "masks of the right image by the network, too, which takes twice the time");
  visit("segmentation.onnx.regions", s.onnx.regions,
        "number of regions around tracks that follow each whole image, seen twice as large");
}

template <typename Config, typename Visitor>
void visit_motion_segmentation(Config& config, Visitor& visit) {
  auto& m = config.segmentation.motion;
  visit("segmentation.motion.sigma_px", m.sigma_px, "standard deviation of a feature's coordinates, px");
  visit("segmentation.motion.ego_sigma_px", m.ego_sigma_px, "error of the ego motion, as image motion, px");
  visit("segmentation.motion.bias_disparity_px", m.bias_disparity_px, "slowly varying error of the disparity, px");
  visit("segmentation.motion.memory_s", m.memory_s, "half-life of an observation's weight, s");
  visit("segmentation.motion.min_disparity_px", m.min_disparity_px, "minimum disparity of a feature that counts, px");
  visit("segmentation.motion.min_speed_mps", m.min_speed_mps, "minimum speed of a moving region, m/s");
  visit("segmentation.motion.min_speed_ratio", m.min_speed_ratio,
        "minimum speed of a moving region, as a part of the camera's speed");
  visit("segmentation.motion.significance", m.significance, "minimum speed of a moving region, in standard deviations");
  visit("segmentation.motion.min_features", m.min_features, "minimum number of features of a moving region");
  visit("segmentation.motion.link_distance_m", m.link_distance_m,
        "maximum distance between neighbouring features of a region, m");
  visit("segmentation.motion.confirm_frames", m.confirm_frames,
        "frames in which a region must move before it is reported");
  visit("segmentation.motion.hold_s", m.hold_s, "time for which a region is kept after it has stopped, s");
}

template <typename Config, typename Visitor>
void visit_tracking(Config& config, Visitor& visit) {
  auto& t = config.tracking;
  visit("tracking.max_objects", t.max_objects, "maximum number of tracks alive at once");
  visit("tracking.confirm_frames", t.confirm_frames, "matched frames until a track is confirmed");
  visit("tracking.max_missed_s", t.max_missed_s, "time without a detection for which a track shows its prediction, s");
  visit("tracking.max_unseen_s", t.max_unseen_s,
        "time for which a track whose place is known then waits to be found again, s");
  visit("tracking.max_tentative_missed_s", t.max_tentative_missed_s,
        "time without a detection after which a tentative track ends, s");
  visit("tracking.min_area_px", t.min_area_px,
        "minimum area of a detection that begins a track, and of a track, pixels");
  visit("tracking.min_overlap", t.min_overlap,
        "minimum intersection over union of prediction and detection in the right image");
  visit("tracking.duplicate_overlap", t.duplicate_overlap,
        "part of a detection on live tracks above which it begins no track");
  visit("tracking.ransac_threshold_px", t.ransac_threshold_px,
        "maximum residual of a feature that supports an object's similarity transform, px");
  visit("tracking.ransac_iterations", t.ransac_iterations,
        "number of RANSAC samples for an object's similarity transform");
}

template <typename Config, typename Visitor>
void visit_bodies(Config& config, Visitor& visit) {
  visit_body(config.background, visit,
             {"background.max_points", "background.window_frames", "background.min_inliers",
              "background.min_inlier_ratio", "background.measurement_sigma_px", "background.min_measurement_sigma_px",
              "background.gate_sigma", "background.ransac_max_hypotheses", "background.min_disparity_px",
              "background.min_parallax_deg", "background.keyframe_motion_px", "background.keyframe_overlap"});
  visit_body(config.object, visit,
             {"object.max_points", "object.window_frames", "object.min_inliers", "object.min_inlier_ratio",
              "object.measurement_sigma_px", "object.min_measurement_sigma_px", "object.gate_sigma",
              "object.ransac_max_hypotheses", "object.min_disparity_px", "object.min_parallax_deg",
              "object.keyframe_motion_px", "object.keyframe_overlap"});
  visit("object.turn_rate_radps", config.object.turn_rate_radps,
        "usual turn rate of an object, rad/s; more only where points show it; 0: no expectation");
  visit("object.stereo_only_min_features", config.objects.stereo_only_min_features,
        "minimum number of stereo features that give a small object its position");
  visit("object.lost_after_s", config.objects.lost_after_s, "time of prediction after which an object is lost, s");
  visit("object.rigid_pedestrians", config.objects.rigid_pedestrians, "reconstruction of people, like vehicles");
}

template <typename Config, typename Visitor>
void visit_trajectory(Config& config, Visitor& visit) {
  auto& j = config.trajectory;
  visit("trajectory.velocity_window_s", j.velocity_window_s, "time before and after over which velocity is fitted, s");
  visit("trajectory.min_moving_speed_mps", j.min_moving_speed_mps, "minimum speed of a moving object, m/s");
  visit("trajectory.moving_significance", j.moving_significance,
        "minimum speed of an object that becomes moving, in standard deviations");
  visit("trajectory.acceleration_mps2", j.motion.acceleration_mps2,
        "standard deviation of an object's acceleration along the ground; in every direction where the ground is not "
        "known, m/s^2");
  visit("trajectory.vertical_acceleration_mps2", j.motion.vertical_acceleration_mps2,
        "the same, along the ground's normal; for what flies as large as along the ground, m/s^2");
  visit("trajectory.vertical_speed_mps", j.motion.vertical_speed_mps,
        "standard deviation of an object's speed along the ground's normal; for what flies as large as its speed, m/s");
  visit("trajectory.turn_radps2", j.motion.turn_radps2,
        "standard deviation of an object's angular acceleration about the ground's normal; about every axis where the "
        "ground is not known, rad/s^2");
  visit("trajectory.tilt_radps2", j.motion.tilt_radps2, "the same, about directions along the ground, rad/s^2");
  visit("trajectory.stereo_sigma_px", j.stereo_sigma_px, "standard deviation of a stereo position, px");
  visit("trajectory.surface_sigma_m", j.surface_sigma_m,
        "drift of the middle of what is seen over a stereo-only object, m");
  visit("trajectory.sizes", j.sizes, "file of the usual sizes of objects; empty: those of config/sizes.yaml");
}

template <typename Config, typename Visitor>
void visit_refinement(Config& config, Visitor& visit) {
  auto& r = config.refinement;
  visit("refinement.max_iterations", r.max_iterations, "maximum number of damped steps per body and frame");
  visit("refinement.robust_threshold_sigmas", r.robust_threshold_sigmas,
        "residual that weighs half (Cauchy loss), in standard deviations");
  visit("refinement.initial_damping", r.initial_damping,
        "initial Levenberg-Marquardt damping, relative to the Hessian's diagonal");
  visit("refinement.relative_cost_tolerance", r.relative_cost_tolerance,
        "relative change of the cost below which a step has converged");
}

template <typename Config, typename Visitor>
void visit_memory(Config& config, Visitor& visit) {
  visit(
      "memory.budget_mib", config.memory.budget_mib,
      "memory of the whole process at its peak, MiB; a plan that needs more is refused; 0: as much as the plan needs");
  visit("memory.libraries_mib", config.memory.libraries_mib, "memory set aside for code and libraries, MiB");
}

}  // namespace detail

/// Calls `visit(key, field, description)` for every setting; keys are dotted, fields are bool, int, float, double,
/// std::string or an enumeration with to_string and from_string.
template <typename Config, typename Visitor>
void visit_fields(Config& config, Visitor&& visit) {
  detail::visit_calibration(config, visit);
  detail::visit_features(config, visit);
  detail::visit_segmentation(config, visit);
  detail::visit_motion_segmentation(config, visit);
  detail::visit_tracking(config, visit);
  detail::visit_bodies(config, visit);
  detail::visit_trajectory(config, visit);
  detail::visit_refinement(config, visit);
  detail::visit_memory(config, visit);
}

}  // namespace kinetrace::pipeline
