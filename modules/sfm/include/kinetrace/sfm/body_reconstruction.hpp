// Incremental sliding-window SfM of the stereo rig relative to one rigid body; the same class for background and
// objects.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/sfm/config.hpp"
#include "kinetrace/sfm/noise_scale.hpp"
#include "kinetrace/sfm/point_map.hpp"
#include "kinetrace/sfm/pose_history.hpp"
#include "kinetrace/sfm/stereo_pose_estimator.hpp"

namespace kinetrace::sfm {

struct BodyCounters {
  std::uint64_t points_created = 0;
  std::uint64_t points_culled = 0;
  std::uint64_t points_evicted =
      0;  ///< Retired before their last observation left the window, to make room for new ones.
  std::uint64_t points_dropped = 0;  ///< Not created: the map was full of points in view.
};

/// One body's points and the camera's path relative to them.
///
/// A frame takes four calls, so that poses are known before masks and new features arrive:
///   locate()   estimates the pose of this frame from the points known so far,
///   extend()   adds this frame to the window, with observations and new points,
///   window()   returns the window that bundle adjustment refines, in place,
///   conclude() culls wrong points; returns the estimate of this frame.
/// The body frame is given at begin() and never moves. Poses are finalised after `window_frames` frames.
class BodyReconstruction {
 public:
  [[nodiscard]] static Result<BodyReconstruction> create(const BodyConfig& config, const StereoGeometry& geometry,
                                                         Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const BodyConfig& config);

  /// Restarts with the present frame, its camera at `T_body_cam`; extend() follows. `status` tells the quality of that
  /// pose: kTracked when known, kPropagated or kLost when only predicted. Points of an earlier life are retired with
  /// this frame.
  void begin(const Se3& T_body_cam, BodyStatus status = BodyStatus::kTracked);
  [[nodiscard]] bool active() const noexcept { return active_; }
  /// Converts the window's measurements to a new correction of the rig.
  void remeasure(const RigChange& change) noexcept;
  /// Invalidates the motion model: the next pose is accepted without a plausibility check.
  void forget_motion() noexcept { last_tracked_ns_.reset(); }
  /// Ends the reconstruction; its remaining points are in `estimate().retired` until the next begin() or reset().
  void end();
  /// Clears everything, as after create; counters continue.
  void reset();

  /// Constant-velocity prediction of T_body_cam at `timestamp_ns`.
  [[nodiscard]] Se3 predict(std::int64_t timestamp_ns) const;
  /// Predicted places of this body's features of the previous frame at `timestamp_ns`, by slot; features without a
  /// prediction are left untouched.
  void predict_features(std::span<const Feature> previous, std::uint8_t label, std::int64_t timestamp_ns,
                        std::span<FeaturePrediction> by_slot) const;

  /// Prior of the caller on the pose of a frame.
  struct Expectation {
    Se3 T_body_cam;
    Matrix6d covariance = Matrix6d::Identity();  ///< Of T_body_cam, left perturbation.
  };

  /// Pose of this frame from known points; kPropagated (prediction) if too few agree. Without an expectation, the
  /// prediction by constant velocity is the initial value, with zero weight.
  const BodyEstimate& locate(const FeatureFrame& frame, std::uint8_t label, const Expectation* expected = nullptr);
  /// After locate(): the caller rejects the pose; the prediction replaces it.
  void refuse_pose();
  /// `R_world_cam`: the camera's attitude in the world, needed for the prior on the body's rotation; null if unknown.
  void extend(const FeatureFrame& frame, std::uint8_t label, const Eigen::Matrix3d* R_world_cam = nullptr);
  [[nodiscard]] BundleWindow window();
  const BodyEstimate& conclude(const BundleSummary& refinement);

  [[nodiscard]] const BodyEstimate& estimate() const noexcept { return estimate_; }
  /// Frames since begin() that the history still holds, at most `window_frames` + 1.
  [[nodiscard]] std::size_t history_size() const noexcept { return history_.size(); }
  /// Pose `age` frames ago; it is final once age == window_frames.
  [[nodiscard]] FinalisedPose history(std::size_t age) const { return history_.at(age, poses_); }
  /// Slots of features that kept disagreeing with the body; valid until the next frame.
  [[nodiscard]] std::span<const std::uint16_t> rejected_slots() const noexcept { return rejected_.span(); }
  /// 1 where a feature agreed with the pose found by locate(), by slot.
  [[nodiscard]] bool agreed(const Feature& feature) const noexcept {
    return verdict_[feature.slot] == Verdict::kInlier;
  }
  [[nodiscard]] const BodyCounters& counters() const noexcept { return counters_; }

 private:
  enum class Verdict : std::uint8_t { kUnknown, kInlier, kOutlier };

  BodyReconstruction(const BodyConfig& config, const StereoGeometry& geometry, Arena& arena);

  /// Observations of points with a position, written to pose_observations_ and pose_slots_.
  struct ObservedPoints {
    std::size_t count = 0;
    std::size_t consensus_size = 0;  ///< The first ones, which select the pose.
    bool is_proven = false;          ///< All points of the consensus set agreed before.
  };
  [[nodiscard]] ObservedPoints observe_points(const FeatureFrame& frame, std::uint8_t label);
  /// Pose with the most agreement in the consensus set; invalid below the configured numbers.
  [[nodiscard]] PoseEstimate find_pose(const ObservedPoints& observed, const PosePrior& prior, double sigma_px);
  /// True if the motion since the camera was last tracked is physically plausible.
  [[nodiscard]] bool is_plausible(const PoseEstimate& pose) const;
  [[nodiscard]] static PosePrior prior_from(const Expectation& expected);
  /// Updates the noise scale from a located frame, for later gates and weights.
  void learn_noise(std::span<const PoseObservation> observations, const Se3& T_cam_body);
  /// Adds the assumed motion to the uncertainty of a prediction.
  void inflate_covariance();

  /// T_cam_body of the window's columns.
  using ColumnPoses = std::array<Se3, kMaxWindowFrames>;

  void advance_window();
  [[nodiscard]] bool newest_is_redundant() const;
  /// Merges the newest column's observations into the column before it, reprojected to that pose, so that a dropped
  /// frame keeps its information on the points.
  void merge_into_keyframe();
  void drop_column(std::size_t column, std::size_t target_column);
  void add_observations(const FeatureFrame& frame, std::uint8_t label);
  [[nodiscard]] BundleObservation observation_of(const Feature& feature) const;
  /// Applies locate()'s verdict; false for a feature with too many disagreements.
  bool classify_point(const Feature& feature);
  [[nodiscard]] bool is_suspect(const Feature& feature) const;
  void disagree(std::size_t slot);
  /// At capacity, points out of view make room for new ones, those last observed longest ago first.
  void evict_for(std::size_t newcomers);
  void position_new_points();
  /// Recomputes points of one observation from their pose; in a window of one frame, all points.
  void reposition_newcomers();
  void cull_points();
  void assess(std::size_t row, const ColumnPoses& T_cam_body);
  [[nodiscard]] ColumnPoses invert_poses() const;
  [[nodiscard]] double observation_chi2(const Se3& T_cam_body, const Eigen::Vector3d& p_body,
                                        const BundleObservation& observation) const;
  [[nodiscard]] float inverse_sigma() const { return static_cast<float>(1.0 / noise_.sigma_px()); }
  void retire(std::size_t row);
  void publish();
  /// Last column that refinement does not move.
  [[nodiscard]] std::size_t find_anchor() const;
  /// Prior on the rotation since the column before.
  [[nodiscard]] TurnPrior expected_turn(std::size_t column) const;
  [[nodiscard]] std::size_t newest_column() const noexcept { return poses_.size() - 1; }

  BodyConfig config_;
  StereoGeometry geometry_;
  StereoPoseEstimator pose_estimator_;
  NoiseScale noise_;
  bool active_ = false;

  // The window: the newest frame is always the last column; unused columns, at the front, hold a copy of the oldest
  // pose.
  std::span<Se3> poses_;
  /// By column: accumulated covariance of a pose since the body began (left perturbation).
  std::span<Matrix6d> drifts_;
  struct CameraAttitude {
    Eigen::Matrix3d R_world_cam = Eigen::Matrix3d::Identity();
    std::int64_t timestamp_ns = 0;
    bool known = false;
  };
  std::span<CameraAttitude> attitudes_;  ///< By column.
  std::span<TurnPrior> turns_;           ///< By column, as of the last window().
  std::size_t used_columns_ = 0;
  std::size_t anchor_column_ = 0;  ///< Of the last window().
  bool newest_redundant_ = false;  ///< The newest frame is dropped for the next one: no new information.
  PointMap map_;
  PoseHistory history_;
  Se3 T_body_cam_now_;  ///< Pose of the frame between locate() and extend().
  std::int64_t frame_index_ = 0;
  std::int64_t timestamp_ns_ = 0;
  std::optional<std::int64_t> last_tracked_ns_;  ///< Frame whose pose was found last; none before the first.
  BodyStatus status_now_ = BodyStatus::kInitializing;
  bool in_window_ = false;  ///< This frame has a usable pose, measured or from begin().

  // By feature slot.
  std::span<Verdict> verdict_;
  std::span<std::uint8_t> disagreements_;    ///< Frames in a row.
  std::span<std::uint32_t> disagreeing_id_;  ///< The feature that `disagreements_` counts for.

  // Scratch and output.
  std::span<PoseObservation> pose_observations_;
  std::span<std::uint16_t> pose_slots_;
  std::span<std::uint8_t> pose_inlier_;
  std::span<float> scratch_;
  FixedVector<BodyPoint> live_;
  FixedVector<BodyPoint> retired_;
  FixedVector<PointObservation> observations_;
  FixedVector<std::uint16_t> rejected_;
  BodyEstimate estimate_;
  BodyCounters counters_;
};

}  // namespace kinetrace::sfm
