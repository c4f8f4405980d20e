// Errors of object detection, tracking and reconstruction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/evaluation/box_metrics.hpp"
#include "kinetrace/evaluation/error_statistics.hpp"

namespace kinetrace::evaluation {

/// Truth of one object in one frame. Only visible objects are listed.
struct TrueObject {
  std::uint32_t id = 0;
  std::uint16_t class_id = 0;
  bool moving = false;
  bool rigid = true;
  int height_px = 0;  ///< Of the visible part.
  /// Fraction occluded or outside the image, 0 to 1; 0 if unknown.
  double hidden = 0.0;
  Se3 T_world_obj;                                         ///< x forward, y down, z left.
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();      ///< World frame, of its box.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();        ///< Length, height, width.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< World frame, of the object's origin.
};

/// A track's estimate of its object in one frame.
struct TrackEstimate {
  BodyStatus status = BodyStatus::kLost;
  Se3 T_world_obj;
  Box3 box;
  Box3Sigma box_sigma;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  bool moving = false;
  double heading_rad = 0.0;  ///< About the world's y axis: 0 = along +x, pi/2 = along -z.
};

/// A track in one frame: it has a mask, an estimate, or both.
struct TrackInFrame {
  std::uint32_t track_id = 0;
  std::optional<TrackEstimate> estimate;
  int covers = -1;  ///< Index of the true object to which most of the track's pixels belong; -1: none or unknown.
};

/// Truth and estimates of one frame, in the same world.
struct ObjectFrame {
  std::int64_t frame = 0;
  Se3 T_world_cam_true;
  std::vector<TrueObject> truth;
  std::vector<TrackInFrame> tracks;
  Eigen::MatrixXd similarity;  ///< Truth x tracks, 0 to 1; see similarity.hpp.
};

struct ObjectConfig {
  double min_similarity = 0.5;      ///< Tracks below this do not match the object (CLEAR MOT, KITTI MOTS).
  double min_height_px = 40.0;      ///< Only objects taller than this count for coverage and errors.
  double motion_range_m = 30.0;     ///< Range of motion, speed and heading: distance from the camera.
  double distance_range_m = 20.0;   ///< Range of the distance to the true trajectory: distance from the camera.
  std::size_t min_track_rows = 5;   ///< With fewer rows, the fitted offset would explain the errors.
  int min_false_moving_frames = 3;  ///< Fewer frames make no false moving track.
  bool truth_is_complete = true;    ///< Objects not in the truth are at rest. False for hand-made labels.
};

struct MotionErrors {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
  void add(const MotionErrors& other) noexcept {
    translation_m.add(other.translation_m);
    rotation_deg.add(other.rotation_deg);
  }
};

/// Status of a motion's poses: the weaker of the two.
inline constexpr std::array<BodyStatus, 3> kPoseSources{BodyStatus::kTracked, BodyStatus::kStereoOnly,
                                                        BodyStatus::kPropagated};

/// Of one object, or of all together.
struct ObjectErrors {
  std::size_t visible_frames = 0;
  std::size_t matched_frames = 0;  ///< Visible, with a matched track.
  std::size_t tall_frames = 0;     ///< Visible and taller than min_height_px.
  std::size_t covered_frames = 0;  ///< Of these: the object's track has a pose that is not lost.
  std::size_t id_switches = 0;     ///< Matched to another track than at its last match.
  std::size_t fragmentations = 0;  ///< Matched again after visible frames without a match.
  /// From frame to frame in the true body frame, of moving rigid objects: H = T_est,k T_est,k-1^-1, B = L_k-1^-1 H
  /// L_k-1, B_true = L_k-1^-1 L_k, error B_true^-1 B, L the true pose. Independent of the choice of the estimated body
  /// frame (Zhang et al., VDO-SLAM, 2020; Morris et al., DynoSAM, 2025).
  MotionErrors motion;
  std::array<MotionErrors, kPoseSources.size()> motion_by_source;  ///< As kPoseSources.
  std::size_t missing_motions = 0;  ///< Frames with a motion in the truth, but a pose is missing or the track changed.
  ErrorStatistics distance_m;       ///< Of the estimated origin, after the best constant offset in the true body frame.
  ErrorStatistics offset_m;         ///< Length of that offset, one for each track: normally at most an object's size.
  ErrorStatistics center_m;     ///< Of the box's centre, nothing fitted; includes the effect of seeing only one side.
  ErrorStatistics speed_mps;    ///< Of moving rigid objects.
  ErrorStatistics heading_deg;  ///< Of moving rigid objects that the estimate reports as moving.
  std::size_t moving_rows = 0;  ///< Poses of moving rigid objects in range ...
  std::size_t found_moving_rows = 0;   ///< ... of these, those reported as moving.
  ErrorStatistics walking_speed_mps;   ///< Of moving objects that are not rigid, people above all.
  ErrorStatistics walking_distance_m;  ///< Of their boxes' centres.
  std::size_t walking_rows = 0;        ///< Poses of these in range ...
  std::size_t found_walking_rows = 0;  ///< ... of these, those reported as moving.
};

/// Error of one motion, from the previous frame to this one.
struct MotionSample {
  std::int64_t frame = 0;
  std::uint32_t object_id = 0;
  std::uint32_t track_id = 0;
  BodyStatus source = BodyStatus::kTracked;  ///< The weaker of the two poses.
  double translation_m = 0.0;
  double rotation_deg = 0.0;
  double distance_m = 0.0;  ///< Of the object from the camera.
  int height_px = 0;        ///< Of the visible part.
};

struct ObjectReport {
  std::uint32_t id = 0;
  std::uint16_t class_id = 0;
  bool moving = false;  ///< In any frame.
  bool rigid = true;
  std::vector<std::uint32_t> track_ids;  ///< In the order in which they were matched.
  ObjectErrors errors;
};

/// A track reported as moving although its object is at rest, or without any object.
struct FalseMovingTrack {
  std::uint32_t track_id = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::size_t frames = 0;
  double mean_speed_mps = 0.0;
  std::optional<std::uint32_t> object_id;  ///< None: it has no object.
};

struct ObjectMetrics {
  ObjectErrors all;
  std::vector<ObjectReport> objects;  ///< By id; visible objects.
  std::vector<MotionSample> motions;  ///< Samples of `all.motion`, by object and frame.
  std::vector<FalseMovingTrack> false_moving;
  BoxMetrics boxes;  ///< Of rigid objects over min_height_px.
};

/// `frames` by frame number. Tracks are matched with objects frame by frame: a match of the previous frame is kept if
/// still similar enough, the rest is assigned by Kuhn-Munkres (CLEAR MOT; Bernardin and Stiefelhagen 2008). An object
/// without a match is represented by its last track unless that is matched to another object.
[[nodiscard]] ObjectMetrics evaluate_objects(std::span<const ObjectFrame> frames, const ObjectConfig& config);

}  // namespace kinetrace::evaluation
