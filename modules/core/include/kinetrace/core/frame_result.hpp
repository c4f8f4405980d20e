// The one public result of the pipeline; all outputs are made from it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/track_frame.hpp"

namespace kinetrace {

struct CameraResult {
  BodyStatus status = BodyStatus::kInitializing;
  Se3 T_world_cam;
  /// Of (rotation about the world's axes, position) in rad and m, relative to the oldest frames of the window.
  Matrix6d covariance = Matrix6d::Zero();
  int inliers = 0;
};

/// One object in one frame.
struct ObjectResult {
  std::uint32_t track_id = 0;  ///< Never reused in a run.
  std::uint8_t label = 0;      ///< Value of its pixels in the frame's label images.
  std::uint16_t class_id = 0;
  BodyStatus status = BodyStatus::kInitializing;
  bool moving = false;  ///< Its speed differs significantly from zero.
  /// Of the smoothed path. Object frame: fixed at birth, never moves with later points.
  Se3 T_world_obj;
  /// The camera in the object frame, from this frame alone. METHOD eq. 2, T_world_obj = T_world_cam * T_obj_cam^-1,
  /// holds before smoothing.
  Se3 T_obj_cam;
  /// Of (rotation about the world's axes, position of the object's origin) in rad and m: of the object frame's place on
  /// the object, relative to where it was fixed at birth. The camera's path counts as known, except for the frames of
  /// the window.
  Matrix6d covariance = Matrix6d::Zero();
  /// World frame, of the box centre. Zero where a frame without own reconstruction shows no significant motion.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  double heading_rad = 0.0;  ///< Of the motion, else of the box; about the world's y axis, 0 = +x, pi/2 = -z.
  Box3 box;
  Box3Sigma box_sigma;
  PixelBox box_px;      ///< Of the left mask.
  int point_count = 0;  ///< Live reconstructed points.
  int inliers = 0;      ///< Features of this frame that agree with the pose.
};

/// Camera and objects at one instant.
struct FrameEstimate {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  CameraResult camera;
  std::span<const ObjectResult> objects;
};

/// Reconstruction data of one body in one frame; track_id 0 is the background.
struct BodyGeometry {
  std::uint32_t track_id = 0;
  BodyStatus status = BodyStatus::kInitializing;
  bool is_keyframe = false;
  std::span<const BodyPoint> points;
  std::span<const PointObservation> observations;
  std::span<const BodyPoint> retired;
};

/// Running totals since start: work done, and items dropped at a capacity.
struct FrameCounters {
  std::uint64_t frames = 0;
  std::uint64_t features_tracked = 0;
  std::uint64_t features_lost = 0;
  std::uint64_t features_created = 0;
  std::uint64_t features_dropped = 0;  ///< Corners not taken: feature capacity reached.
  std::uint64_t stereo_matched = 0;
  std::uint64_t detections = 0;
  std::uint64_t detections_dropped = 0;        ///< Instances beyond max_objects or too small.
  std::uint64_t detection_frames_missing = 0;  ///< Frames without detections: no mask, or an unusable one.
  std::uint64_t mask_files_unreadable = 0;     ///< Damaged, or of another size or type.
  std::uint64_t tracks_born = 0;
  std::uint64_t tracks_confirmed = 0;
  std::uint64_t tracks_ended = 0;
  std::uint64_t points_created = 0;
  std::uint64_t points_culled = 0;
  std::uint64_t points_dropped = 0;  ///< Points not made: map capacity reached.
  std::uint64_t background_lost_frames = 0;
};

struct FrameCounterName {
  std::string_view name;
  std::uint64_t FrameCounters::*member;
};
/// All of FrameCounters, by their names in outputs.
inline constexpr std::array<FrameCounterName, 17> kFrameCounterNames{{
    {"frames", &FrameCounters::frames},
    {"features_tracked", &FrameCounters::features_tracked},
    {"features_lost", &FrameCounters::features_lost},
    {"features_created", &FrameCounters::features_created},
    {"features_dropped", &FrameCounters::features_dropped},
    {"stereo_matched", &FrameCounters::stereo_matched},
    {"detections", &FrameCounters::detections},
    {"detections_dropped", &FrameCounters::detections_dropped},
    {"detection_frames_missing", &FrameCounters::detection_frames_missing},
    {"mask_files_unreadable", &FrameCounters::mask_files_unreadable},
    {"tracks_born", &FrameCounters::tracks_born},
    {"tracks_confirmed", &FrameCounters::tracks_confirmed},
    {"tracks_ended", &FrameCounters::tracks_ended},
    {"points_created", &FrameCounters::points_created},
    {"points_culled", &FrameCounters::points_culled},
    {"points_dropped", &FrameCounters::points_dropped},
    {"background_lost_frames", &FrameCounters::background_lost_frames},
}};
static_assert(sizeof(FrameCounters) == kFrameCounterNames.size() * sizeof(std::uint64_t), "a counter has no name");

/// Complete result of one processed frame. Spans and views live in the pipeline until its next call.
struct FrameResult {
  FrameEstimate newest;
  bool has_finalised = false;
  FrameEstimate finalised;  ///< An earlier frame that has just left the window: its estimate is final.
  std::span<const BodyGeometry> bodies;
  std::span<const Track> tracks;
  RectifiedPair pair;
  LabelView left_labels;
  LabelView right_labels;
  FrameCounters counters;
  RigEstimate rig;  ///< Calibration as refined so far.
};

}  // namespace kinetrace
