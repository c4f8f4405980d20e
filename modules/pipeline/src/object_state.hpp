// One object slot: reconstruction and trajectory of its object.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>

#include "camera/camera_state.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/track_frame.hpp"
#include "kinetrace/objects/motion_filter.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "kinetrace/tracking/prediction.hpp"
#include "kinetrace/trajectory/box_estimator.hpp"
#include "kinetrace/trajectory/object_motion.hpp"
#include "stereo_observation.hpp"
#include "trajectory_buffer.hpp"

namespace kinetrace::pipeline {

/// A track's object from first to last frame. Its first tracked reconstruction fixes its frame: origin at the median of
/// its stereo points, axes parallel to the world's when that reconstruction began. Pose source per frame, in this
/// order: own reconstruction (tracked), stereo position (stereo_only), prediction (propagated).
class ObjectState {
 public:
  [[nodiscard]] static Result<ObjectState> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                  Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  [[nodiscard]] bool in_use() const noexcept { return life_.track.id != 0; }
  /// In use, and its track has not ended with this frame.
  [[nodiscard]] bool alive() const noexcept { return in_use() && !life_.ended; }
  [[nodiscard]] const Track& track() const noexcept { return life_.track; }
  /// As it was in the previous frame.
  [[nodiscard]] const Track& track_before() const noexcept { return life_.track_before; }
  /// Its track is confirmed, and it is an object: reported.
  [[nodiscard]] bool confirmed() const noexcept { return life_.confirmed; }
  /// Its position has been known at least once.
  [[nodiscard]] bool has_position() const noexcept { return life_.status != BodyStatus::kInitializing; }
  /// The track is where this object cannot be: it has switched to another object.
  [[nodiscard]] bool identity_switched() const noexcept { return frame_.identity_switched; }

  void begin(const Track& track);
  /// Predicted image position of the object's origin at `timestamp_ns`, given the camera at that time. Only its
  /// direction before it has a position.
  [[nodiscard]] tracking::ObjectPrediction prediction(std::int64_t timestamp_ns, const Se3& T_world_cam) const;
  /// The track has ended, or continues in another slot; points still alive are in `body().estimate().retired`.
  void end();
  /// Its detection belongs to another object: it waits as this track for re-identification.
  void set_dormant(const Track& track) noexcept;
  /// Its positions were measured with a calibration that was far off: the path restarts with the next frame.
  void restart_path() noexcept;
  /// The slot may be given to another track.
  void release() noexcept { life_.track = Track{}; }

  /// Stereo measurement of this object; empty without features.
  [[nodiscard]] StereoObservation observe_stereo(const FeatureFrame& frame, LabelView labels,
                                                 const CameraState& camera) const;
  /// Log-likelihood ratio of `observation`, of the new track `redetected`, showing this lost object, against a new one.
  /// Nothing if this one has no position, is of another class, or was still detected when the new track already was.
  [[nodiscard]] std::optional<double> position_evidence(const StereoObservation& observation, const Track& redetected,
                                                        const CameraState& camera) const;
  /// The same for an object of which only the direction is known, by the mask of `redetected`.
  [[nodiscard]] std::optional<double> bearing_evidence(const Track& redetected, const CameraState& camera) const;
  /// Re-identification: this slot's new track continues the identity and frame of `earlier`. Call before observe().
  void continue_from(ObjectState& earlier);

  /// Pose of this frame, and observations added to the window.
  /// `labels`: the masks of the left image, by track label.
  void observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera);
  /// After refinement: completes the newest estimate of this frame.
  void conclude(const BundleSummary& refinement, const CameraState& camera, const trajectory::Ground& ground);
  /// Writes the newest estimate into `result`.
  void report(ObjectResult& result) const;
  /// Updates a buffered result of `age` frames ago by the window, given the camera's newest estimate for that frame.
  void revise(std::size_t age, const CameraState& camera, ObjectResult& result);
  /// Has been reconstructed for a while and is slow by its path.
  [[nodiscard]] bool at_rest() const noexcept;
  /// Restarts the filter from the smoothed path: pose at the newest frame and velocity in the body's own axes (rad/s,
  /// m/s).
  void reinitialise_filter(const Se3& T_world_obj, const Vector6d& velocity) noexcept;
  /// Velocity, heading and box of a buffered result, from the trajectory before and after it.
  void describe_motion(std::size_t age, ObjectResult& result) const;

  [[nodiscard]] sfm::BodyReconstruction& body() noexcept { return body_; }
  [[nodiscard]] const sfm::BodyReconstruction& body() const noexcept { return body_; }
  /// Has been tracked by its reconstruction since its path began.
  [[nodiscard]] bool reconstructed() const noexcept { return identity_.reconstructed; }
  [[nodiscard]] BodyStatus status() const noexcept { return life_.status; }
  /// Without pixels, and lost or predicted outside the image: not reported.
  [[nodiscard]] bool is_out_of_view() const noexcept {
    return life_.track.area_px == 0 && (life_.status == BodyStatus::kLost || !is_in_view());
  }
  [[nodiscard]] FrameChange frame_change() const noexcept { return frame_.change; }
  /// Drift of its frame on its points since it was fixed, and error of guesses at restarts: covariance of a left
  /// perturbation of T_obj_cam.
  [[nodiscard]] Matrix6d drift_covariance() const {
    return identity_.drift_covariance + body_.estimate().drift_covariance;
  }
  /// True while the body takes part in this frame's refinement.
  [[nodiscard]] bool reconstructing() const noexcept { return frame_.extended; }

 private:
  /// On a mask: fewer may all be another object's, and are neither evidence of motion nor of another identity.
  static constexpr int kMinOwnFeatures = 4;
  static constexpr float kClearlyVisible = 0.6F;  ///< Where less is visible, the visible part may well be the occluder.

  /// State that continues under another track when the object is re-identified, besides its box.
  struct Identity {
    explicit Identity(const objects::MotionFilter& unstarted) : filter(unstarted) {}

    /// Has been tracked by its reconstruction since it was last restarted: this has fixed its axes and origin.
    bool reconstructed = false;
    bool has_moved = false;  ///< Has been found moving, by its path.
    /// Probability of moving, by the path of its reconstruction. Before there is one the object is rather followed as
    /// moving: a filter at rest would lag behind.
    double moving_probability = 0.95;
    objects::MotionFilter filter;
    Se3 T_world_obj;
    /// Drift of its frame on its points before the present reconstruction, and error of the guess that it began with:
    /// of a left perturbation of T_obj_cam.
    Matrix6d drift_covariance = Matrix6d::Zero();
    Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();  ///< From the centre of the visible part, object axes.
    /// Reference point of the path, object frame: the centre of the points, which errors of rotation move least.
    Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();
    double area_m2 = 0.0;  ///< Of its mask, across the line of sight, recent maximum.
    double width_m = 0.0;  ///< Across the line of sight, when last seen whole.
  };

  /// State of the track in this slot. Counts are of attempts to fit; the rest are times.
  struct Life {
    Track track;
    Track track_before;
    bool confirmed = false;
    bool ended = false;
    BodyStatus status = BodyStatus::kInitializing;
    int frames = 0;
    int detections = 0;  ///< Frames with one.
    std::int64_t timestamp_ns = 0;
    std::int64_t matched_timestamp_ns = 0;  ///< When a detection last showed it.
    bool provisional = false;               ///< Detected again after a gap, before stereo has confirmed it.
    DwellTime predicted;                    ///< Uninterrupted time of prediction.
    int rejections = 0;                     ///< Implausible stereo positions in a row.
    Se3 T_obj_cam;
    Matrix6d covariance = Matrix6d::Zero();          ///< As ObjectResult::covariance.
    std::optional<Eigen::Vector3d> direction_world;  ///< From the camera, while it has no position.
  };

  /// State of this frame.
  struct Frame {
    bool extended = false;
    bool identity_switched = false;
    FrameChange change = FrameChange::kNone;  ///< Of several, the greatest.
    int observed_features = 0;                ///< By stereo.
    double area_before_m2 = 0.0;
    float visible_fraction = 1.F;
    std::int64_t interval_ns = kUsualInterval_ns;
    double interval_s = 0.0;  ///< Since the previous frame; 0 in the first one.
  };

  ObjectState(const PipelineConfig& config, const StereoGeometry& geometry, sfm::BodyReconstruction body, Arena& arena);

  /// Locates a person by the outline: features on swinging limbs do not locate the body, its head and the mean column
  /// of its outline do. Depth remains that of the features. A head cut off by the image border is taken from the last
  /// pose.
  void observe_by_outline(LabelView labels, const CameraState& camera, StereoObservation& observation) const;
  /// A class vote that changes later does not undo a reconstruction that works.
  [[nodiscard]] bool is_rigid() const noexcept {
    return config_.rigid_pedestrians || body_.active() || life_.track.class_id != kPedestrianClass;
  }
  /// Truncated or mostly occluded: the centre of the visible part does not locate the whole, and may lie on the
  /// occluder.
  [[nodiscard]] bool is_truncated_or_occluded() const noexcept { return is_truncated() || is_mostly_occluded(); }
  /// Truncated by the left or right image border.
  [[nodiscard]] bool is_truncated() const noexcept {
    return life_.track.box_px.x0 <= 1 || life_.track.box_px.x1 >= geometry_.width_px - 1;
  }
  /// Bounded below, as a divisor.
  [[nodiscard]] double visible_part() const noexcept {
    constexpr double kMinVisible = 0.2;
    return std::clamp(double{life_.track.visible_part}, kMinVisible, 1.0);
  }
  [[nodiscard]] bool is_mostly_occluded() const noexcept {
    return std::min(life_.track.visible_part, frame_.visible_fraction) < kClearlyVisible;
  }
  /// The centre of its visible part lies in the image, at the end of the last frame.
  [[nodiscard]] bool is_in_view() const;
  /// Not merely a moving region: that has to be found moving by its path, too, or in as many frames as there are until
  /// the result of its first one is final.
  [[nodiscard]] bool is_an_object() const noexcept;
  /// Updates the track and the time since the previous frame.
  void begin_frame(const Track& track, std::int64_t timestamp_ns, const CameraState& camera);
  /// Visible fraction of its recent area: an occluder need not be a tracked object.
  void measure_visible_fraction(const CameraState& camera);
  /// `redetected` is of its class and began after its last detection.
  [[nodiscard]] bool is_reid_candidate(const Track& redetected) const noexcept;
  /// Prediction of an object too far away for stereo: its last direction, if only the camera's rotation moves it in the
  /// image.
  [[nodiscard]] tracking::ObjectPrediction predict_direction(const Se3& T_world_cam) const;
  void record_direction(const CameraState& camera);
  [[nodiscard]] bool initialise_position(const StereoObservation& observation, const CameraState& camera);

  // Pose by the reconstruction.
  [[nodiscard]] bool locate(const FeatureFrame& frame, const CameraState& camera);
  /// Pose predicted by the filter. Nothing before its path determines the motion.
  [[nodiscard]] std::optional<sfm::BodyReconstruction::Expectation> expected_pose(const CameraState& camera) const;
  /// Whether the pose of the reconstruction lies within the gate of the predicted one (chi-square).
  [[nodiscard]] bool passes_innovation_gate(const sfm::BodyReconstruction::Expectation& expected) const;
  /// (Re)starts the reconstruction at the object's current pose.
  void begin_body(const StereoObservation& observation, const CameraState& camera);
  void compose_newest(const CameraState& camera);

  // Pose without a reconstruction.
  void follow(const StereoObservation& observation, const CameraState& camera);
  /// True if the filter's position has been measured by stereo.
  bool update_filter_by_position(const StereoObservation& observation, const CameraState& camera);
  void update_filter_by_motion(const StereoObservation& observation, const CameraState& camera);
  /// Its visible part, as predicted.
  [[nodiscard]] objects::VisiblePart visible_part_of(const Se3& T_world_cam) const;
  [[nodiscard]] objects::Bearing mask_bearing(const CameraState& camera) const;
  /// Restarts the path where it is measured: its mask was on another object before.
  void restart_at_observation(const StereoObservation& observation, const CameraState& camera);
  void update_status(bool is_located) noexcept;
  /// Covariance of the visible part's centre on the object, world axes: over the visible surface, over what is hidden,
  /// and of its depth. `part_cam_m`: that centre as predicted, not as measured, which may lie on another surface.
  [[nodiscard]] Eigen::Matrix3d part_covariance(const Eigen::Vector3d& part_cam_m,
                                                const Eigen::Matrix3d& R_world_cam) const;
  /// Of it, that over the surface and by the hidden part.
  [[nodiscard]] Eigen::Matrix3d extent_covariance(double depth_m) const;
  /// Of the upper end of an outline; nothing for rigid objects.
  [[nodiscard]] Eigen::Matrix3d top_covariance(const Eigen::Matrix3d& R_world_cam) const;
  /// Of it, that by the hidden part: uniform over the part of the box that is hidden.
  [[nodiscard]] Eigen::Matrix3d hidden_covariance(double visible_width_m) const;

  // Motion.
  /// Restarts the filter from a pose and velocity (body axes) of its path.
  void start_filter(const Se3& T_world_obj, const Vector6d& velocity, const Se3& T_world_cam) noexcept;
  /// Updates the probability of moving by the velocity of its path.
  void update_moving_probability() noexcept;
  /// Velocity of the point at `arm_world_m` from the reference point, world frame.
  [[nodiscard]] static Eigen::Vector3d velocity_at(const trajectory::MotionEstimate& motion,
                                                   const Eigen::Vector3d& arm_world_m);
  /// Centre of the visible part, in the world.
  [[nodiscard]] Eigen::Vector3d visible_center_m() const { return identity_.T_world_obj * -identity_.to_origin_m; }
  /// The same in the camera frame.
  [[nodiscard]] Eigen::Vector3d visible_center_in_camera_m(const CameraState& camera) const {
    return camera.T_world_cam.inverse() * visible_center_m();
  }
  /// Its position is that of enough features in this frame. A predicted one continues the last motion.
  [[nodiscard]] bool is_measured() const noexcept;
  /// See trajectory::MotionSample.
  [[nodiscard]] Eigen::Matrix3d position_correlated_covariance() const;
  /// See trajectory::MotionSample; nothing once it has moved.
  [[nodiscard]] Eigen::Matrix3d part_drift_covariance() const;
  /// See trajectory::MotionSample.
  [[nodiscard]] Eigen::Matrix3d covariance_per_disparity(const CameraState& camera) const;
  void push_motion(const CameraState& camera);
  /// Of Identity::reference_m, in the world.
  [[nodiscard]] Eigen::Matrix3d reference_covariance(const Se3& T_world_obj, const Matrix6d& covariance) const;

  // Its box.
  /// Heading in the world, if it moves.
  [[nodiscard]] std::optional<trajectory::Heading> heading(const Eigen::Vector3d& down) const;
  /// Of its mask, if it is detected.
  [[nodiscard]] std::optional<trajectory::MaskEdges> mask_edges() const;
  void update_box(const CameraState& camera, const trajectory::Ground& ground);
  void update_reference_point();
  /// Of its box in a buffered result: that of the box on the object, and that of the object's pose.
  [[nodiscard]] Box3Sigma box_sigma(const ObjectResult& result) const;

  ObjectConfig config_;
  std::int64_t lost_after_ns_;
  double surface_sigma_m_;
  int min_points_;
  double min_disparity_px_;
  double turn_rate_radps_;
  bool found_by_motion_;  ///< Detections without a class are moving regions.
  int window_frames_;     ///< Until a frame's result is final.
  StereoGeometry geometry_;
  Identity identity_;
  Life life_;
  Frame frame_;
  bool path_restarts_ = false;  ///< With the next frame.
  sfm::BodyReconstruction body_;
  trajectory::ObjectMotion motion_;
  trajectory::BoxEstimator box_;
};

}  // namespace kinetrace::pipeline
