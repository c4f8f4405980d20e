// One object slot: the reconstruction of the object that holds it, and its trajectory.
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
#include "object_recogniser.hpp"
#include "stereo_observation.hpp"
#include "trajectory_buffer.hpp"

namespace kinetrace::pipeline {

/// A track's object from birth to end. Its frame is fixed at birth: origin at the median of its stereo points, axes
/// parallel to the world's. Pose source per frame, in this order: own reconstruction (tracked), stereo position
/// (stereo_only), prediction (propagated).
class ObjectState {
 public:
  [[nodiscard]] static Result<ObjectState> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                  Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  [[nodiscard]] bool in_use() const noexcept { return life_.track.id != 0; }
  /// In use, and its track has not ended with this frame.
  [[nodiscard]] bool alive() const noexcept { return in_use() && !life_.ended; }
  [[nodiscard]] const Track& track() const noexcept { return life_.track; }
  /// As it was in the frame before.
  [[nodiscard]] const Track& track_before() const noexcept { return life_.track_before; }
  [[nodiscard]] bool confirmed() const noexcept { return life_.confirmed; }
  /// Its position has been known at least once.
  [[nodiscard]] bool placed() const noexcept { return life_.placed; }
  /// What the track lies on is not where this object can be: it has passed to another object.
  [[nodiscard]] bool identity_switched() const noexcept { return life_.identity_switched; }

  void begin(const Track& track);
  /// Where the object's origin is expected at `timestamp_ns`, the camera of that time given. Unknown before it has a
  /// place.
  [[nodiscard]] tracking::ObjectPrediction prediction(std::int64_t timestamp_ns, const Se3& T_world_cam) const;
  /// The track has ended, or goes on in another slot; points still alive are in `body().estimate().retired`.
  void end();
  /// Its detection shows something else: it waits as this track to be re-identified.
  void wait_as(const Track& track) noexcept;
  /// Where it was has been measured with a calibration that was far off: its path begins anew with the next frame.
  void restart_path() noexcept;
  /// The slot may be given to another track.
  void release() noexcept { life_.track = Track{}; }

  /// What stereo sees of this object; without features nothing.
  [[nodiscard]] StereoObservation observe_stereo(const FeatureFrame& frame, LabelView labels) const {
    return pipeline::observe_stereo(frame, labels, life_.track.label(), min_disparity_px_);
  }
  /// Log-likelihood ratio of `observation`, of the new track `redetected`, showing this lost object, against a new one.
  /// Nothing if this one is in view or of another class, or was still detected when the new track already was.
  [[nodiscard]] std::optional<double> position_evidence(const StereoObservation& observation, const Track& redetected,
                                                        const CameraState& camera) const;
  /// The same for an object of which only the direction is known, by the mask of `redetected`.
  [[nodiscard]] std::optional<double> bearing_evidence(const Track& redetected, const CameraState& camera) const;
  /// Whether `redetected`, of which stereo sees nothing yet, may be this object that comes back over the border of the
  /// image: for some frames, until stereo tells, it has no name.
  [[nodiscard]] bool may_come_back_as(const Track& redetected, const CameraState& camera) const;
  /// This slot's new track is the object that `earlier` has lost: its name and frame go on. Call before observe().
  void continue_from(ObjectState& earlier);

  /// Pose of this frame, and observations added to the window.
  /// `labels`: the masks of the left image, by track label.
  void observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera,
               const features::FeatureFrontEnd& front_end);
  /// After conclude(): takes note of what its points look like, now and then.
  void remember(const FeatureFrame& frame, const features::FeatureFrontEnd& front_end) {
    if (life_.status == BodyStatus::kTracked && !life_.pose_ambiguous) {
      recogniser_.remember(body_, frame, life_.track.label(), front_end, frame_.interval_ns);
    }
  }
  /// After refinement: final newest estimate of this frame.
  void conclude(const BundleSummary& refinement, const CameraState& camera, const trajectory::Ground& ground);
  /// Writes what is known into `result`.
  void report(ObjectResult& result) const;
  /// Updates a kept result of `age` frames ago to what the window knows by now, the camera's newest estimate for that
  /// frame given.
  void revise(std::size_t age, const CameraState& camera, ObjectResult& result);
  /// Has been reconstructed for a while without showing motion.
  [[nodiscard]] bool at_rest() const noexcept;
  /// How it moves, from its smoothed path: pose at the newest frame and velocity in the body's own axes (rad/s, m/s).
  void learn_motion(const Se3& T_world_obj, const Vector6d& velocity) noexcept;
  /// Velocity, heading and box of a kept result, from the trajectory before and after it.
  void describe_motion(std::size_t age, ObjectResult& result) const;

  [[nodiscard]] sfm::BodyReconstruction& body() noexcept { return body_; }
  [[nodiscard]] const sfm::BodyReconstruction& body() const noexcept { return body_; }
  [[nodiscard]] BodyStatus status() const noexcept { return life_.status; }
  /// Not seen for so long, or so far outside the image, that there is nothing to report.
  [[nodiscard]] bool is_out_of_view() const noexcept {
    return life_.track.area_px == 0 && (life_.status == BodyStatus::kLost || !life_.in_view);
  }
  [[nodiscard]] FrameChange frame_change() const noexcept { return frame_.change; }
  /// By how much its frame has drifted on its points since it was fixed, and may have been guessed wrongly: covariance
  /// of a left perturbation of T_obj_cam.
  [[nodiscard]] Matrix6d drift_covariance() const {
    return identity_.drift_covariance + body_.estimate().drift_covariance;
  }
  /// Made in this frame.
  [[nodiscard]] const std::optional<FrameCorrection>& correction() const noexcept { return frame_.correction; }
  /// True while the body takes part in this frame's refinement.
  [[nodiscard]] bool reconstructing() const noexcept { return frame_.extended; }

 private:
  /// Matched for longer without a break: where it is may be wrong, what it is is not.
  static constexpr std::int64_t kSureOfItsMask_ns = 400'000'000;
  static constexpr float kClearlyVisible = 0.6F;  ///< Where more is hidden, what is seen may well be what hides it.

  /// What goes on under another track when the object is re-identified, besides its box and its appearance.
  struct Identity {
    explicit Identity(const objects::MotionFilter& unstarted) : filter(unstarted) {}

    bool frame_fixed = false;    ///< Its axes and origin have been shown in a reconstruction and never move again.
    bool reconstructed = false;  ///< Has been tracked by its reconstruction since it was last given up.
    bool has_moved = false;      ///< Has been found moving.
    /// Probability, by the path of its reconstruction. Before there is one the object is rather followed as moving: at
    /// rest, it would lag behind what is seen of it.
    double moving = 0.95;
    objects::MotionFilter filter;
    Se3 T_world_obj;
    /// By how much its frame had drifted on its points before the present reconstruction, or was guessed wrongly with
    /// it: of a left perturbation of T_obj_cam.
    Matrix6d drift_covariance = Matrix6d::Zero();
    Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();  ///< From the middle of what is seen, object axes.
    /// Point whose path is followed, object frame: the middle of the points. Their errors of rotation move it least.
    Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();
    double area_m2 = 0.0;  ///< Of its mask, across the line of sight, as large as it has lately been.
    double width_m = 0.0;  ///< Across the line of sight, when last seen whole.
  };

  /// What belongs to the track in this slot. Counts are of fits, each of which is another chance; the rest are times.
  struct Life {
    Track track;
    Track track_before;
    bool confirmed = false;
    bool ended = false;
    bool identity_switched = false;
    bool placed = false;  ///< Its place has been known since birth.
    bool in_view = true;  ///< Where it is expected lies in the image.
    BodyStatus status = BodyStatus::kInitializing;
    int frames = 0;
    std::int64_t timestamp_ns = 0;
    std::int64_t matched_timestamp_ns = 0;  ///< When a detection last showed it.
    bool provisional = false;               ///< Detected again after a break, before stereo has confirmed it.
    DwellTime matched_run;                  ///< Without a break in which detections showed it.
    DwellTime predicted;                    ///< Without a break.
    int rejections = 0;                     ///< Implausible stereo positions in a row.
    int failed_residuals = 0;               ///< In a row.
    /// Frames without a pose although points were seen; a frame with one takes half back.
    double inconsistencies = 0.0;
    bool pose_ambiguous = false;                   ///< Its frame has been guessed on its return.
    Matrix6d guess_covariance = Matrix6d::Zero();  ///< The part of Identity::drift_covariance that the guess has.
    std::size_t ambiguous_frames = 0;  ///< Before this one, tracked or not: they are corrected once it is known.
    DwellTime ambiguous_time;          ///< Since its reconstruction last began.
    Se3 T_obj_cam;
    Matrix6d covariance = Matrix6d::Zero();          ///< As ObjectResult::covariance.
    std::optional<Eigen::Vector3d> direction_world;  ///< From the camera, while it has no place.
  };

  /// What belongs to this frame.
  struct Frame {
    bool extended = false;
    FrameChange change = FrameChange::kNone;  ///< Of several, the greatest.
    std::optional<FrameCorrection> correction;
    int observed_features = 0;  ///< By stereo.
    double area_before_m2 = 0.0;
    float visible_fraction = 1.F;
    std::int64_t interval_ns = kUsualInterval_ns;
    double interval_s = 0.0;  ///< Since the frame before; 0 in the first one.
  };

  ObjectState(const PipelineConfig& config, const StereoGeometry& geometry, sfm::BodyReconstruction body, Arena& arena);

  /// Where features happen to lie on something that bends and swings says little about where it is: its head and the
  /// middle of its outline stay where they are. Depth remains that of the features. What the image's border cuts off is
  /// taken from where the object was.
  void observe_by_outline(LabelView labels, const CameraState& camera, StereoObservation& observation) const;
  /// A class vote that changes later does not undo a reconstruction that works.
  [[nodiscard]] bool rigid() const noexcept {
    return config_.rigid_pedestrians || body_.active() || life_.track.class_id != kPedestrianClass;
  }
  /// Much of the object is outside the image or behind something: the middle of what is left of it says little about
  /// the whole, and may be what hides it.
  [[nodiscard]] bool half_hidden() const noexcept { return cut_off() || mostly_occluded(); }
  /// By the image's border.
  [[nodiscard]] bool cut_off() const noexcept {
    return life_.track.box_px.x0 <= 1 || life_.track.box_px.x1 >= geometry_.width_px - 1;
  }
  [[nodiscard]] bool is_newly_matched() const noexcept { return !life_.matched_run.exceeds(kSureOfItsMask_ns); }
  /// Bounded below, as a divisor.
  [[nodiscard]] double visible_part() const noexcept {
    constexpr double kMinVisible = 0.2;
    return std::clamp(double{life_.track.visible_part}, kMinVisible, 1.0);
  }
  [[nodiscard]] bool mostly_occluded() const noexcept {
    return std::min(life_.track.visible_part, frame_.visible_fraction) < kClearlyVisible;
  }
  /// From the nearest point of its box to `observed_m`. Another end of it may come into sight than the one that went.
  [[nodiscard]] Eigen::Vector3d off_body(const Eigen::Vector3d& observed_m) const;
  /// What is seen as that point of its body, the nearest.
  [[nodiscard]] objects::StereoPosition nearest_on_body(const StereoObservation& observation,
                                                        const CameraState& camera) const;
  /// The track as it is now, and the time since the frame before.
  void begin_frame(const Track& track, std::int64_t timestamp_ns, const CameraState& camera);
  /// What stands in front of it need not be an object: how much of the area that it has lately shown is seen now.
  void measure_visible_fraction(const CameraState& camera);
  /// A track of its class that was born after it was last detected, longer than `missed_ns` ago.
  [[nodiscard]] bool is_reid_candidate(const Track& redetected, std::int64_t missed_ns) const noexcept;
  /// Of something too far away for stereo: where it was last seen, if only the camera turns.
  [[nodiscard]] tracking::ObjectPrediction predict_direction(const Se3& T_world_cam) const;
  void note_direction(const CameraState& camera);
  [[nodiscard]] bool place(const StereoObservation& observation, const CameraState& camera);

  // Its pose by its reconstruction.
  [[nodiscard]] bool locate(const FeatureFrame& frame, const StereoObservation& observation, const CameraState& camera);
  [[nodiscard]] bool find_pose(const FeatureFrame& frame, const StereoObservation& observation,
                               const CameraState& camera);
  /// Most of what stereo sees on its mask lies clearly outside its box, were this its pose.
  [[nodiscard]] bool is_seen_elsewhere(const StereoObservation& observation, const Se3& T_obj_cam) const;
  void count_inconsistency(bool found) noexcept;
  /// The reconstruction has not fitted for so long that its points must be wrong.
  [[nodiscard]] bool fails_residual_check(const CameraState& camera);
  /// Where the filter expects it. Nothing before its path has shown how it moves.
  [[nodiscard]] std::optional<sfm::BodyReconstruction::Expectation> expected_pose(const CameraState& camera) const;
  /// Nearly all known points agree with the pose found, and they are many.
  [[nodiscard]] bool has_inlier_consensus() const;
  /// Whether the object can have come from where it was to where the reconstruction sees it now.
  [[nodiscard]] bool passes_innovation_gate(const sfm::BodyReconstruction::Expectation& expected) const;
  /// Puts it where its remembered points are; false if too few are recognised.
  bool recognise(const CameraState& camera, const features::FeatureFrontEnd& front_end);
  /// The reconstruction (re)starts where the object is taken to be.
  void begin_body(const StereoObservation& observation, const CameraState& camera,
                  const features::FeatureFrontEnd& front_end);
  /// The reconstruction begins in a frame that is only as sure as where the object is taken to be.
  void add_guess();
  /// Guesses since it was last known turn out to be right, or are corrected.
  void withdraw_guess();
  /// Its frame has been guessed on its return; true once it is known for sure.
  void resolve_pose(const CameraState& camera, const features::FeatureFrontEnd& front_end);
  void compose_newest(const CameraState& camera);

  // Its pose without one.
  void follow(const StereoObservation& observation, const CameraState& camera);
  /// What stereo has shown of its place.
  enum class Fix : std::uint8_t {
    kNone,
    kForeseen,  ///< It is where it was expected, which is known better than from what is seen of it.
    kStereo,
  };
  /// Measurements of this frame, as surely as they tell.
  Fix measure(const StereoObservation& observation, const CameraState& camera);
  Fix measure_place(const StereoObservation& observation, const CameraState& camera);
  void measure_motion(const StereoObservation& observation, const CameraState& camera);
  /// Of what is half hidden, the middle of what is seen lies where its box is expected: nothing new.
  [[nodiscard]] bool lies_on_body(const StereoObservation& observation, const CameraState& camera) const;
  /// Of what is half hidden, the middle of what is seen may be anywhere on it, as it may where that does not fit: only
  /// how far it lies outside its box says that it is elsewhere.
  [[nodiscard]] objects::StereoPosition stereo_position(const StereoObservation& observation,
                                                        const CameraState& camera) const;
  [[nodiscard]] objects::Bearing mask_bearing() const;
  /// Where it is seen now, it cannot be: its mask has passed to something else, or was on something else before.
  void give_up_path(const StereoObservation& observation, const CameraState& camera);
  void count_prediction(Fix fix) noexcept;
  /// How far the middle of what is seen may lie from where it was: over the surface, and by what is hidden.
  [[nodiscard]] double extent_sigma_m(double depth_m) const;
  [[nodiscard]] double depth_sigma_m(double depth_m) const;

  // How it moves.
  /// The filter goes on from this pose and velocity (body axes), which its path has shown.
  void start_filter(const Se3& T_world_obj, const Vector6d& velocity) noexcept;
  /// Moving or at rest, by the velocity that its path shows.
  void weigh_motion() noexcept;
  /// Velocity of another point of the object than that whose path is followed, world frame.
  [[nodiscard]] static Eigen::Vector3d velocity_at(const trajectory::MotionEstimate& motion,
                                                   const Eigen::Vector3d& arm_world_m);
  /// The middle of what has been seen of it, in the world.
  [[nodiscard]] Eigen::Vector3d middle_m() const { return identity_.T_world_obj * -identity_.to_origin_m; }
  /// See trajectory::MotionSample.
  [[nodiscard]] Eigen::Matrix3d position_correlated_covariance() const;
  /// See trajectory::MotionSample.
  [[nodiscard]] Eigen::Matrix3d covariance_per_disparity(const CameraState& camera) const;
  void push_motion(const CameraState& camera);
  /// Of Identity::reference_m, in the world.
  [[nodiscard]] Eigen::Matrix3d reference_covariance(const Se3& T_world_obj, const Matrix6d& covariance) const;

  // Its box.
  /// Where it heads in the world, if it moves.
  [[nodiscard]] std::optional<trajectory::Heading> heading(const Eigen::Vector3d& down) const;
  /// Of its mask, if a detection shows it.
  [[nodiscard]] std::optional<trajectory::MaskEdges> mask_edges() const;
  void update_box(const CameraState& camera, const trajectory::Ground& ground);
  void follow_middle();
  /// Of its box in a kept result: that of the box on the object, and that of the object's pose.
  [[nodiscard]] Box3Sigma box_sigma(const ObjectResult& result) const;

  ObjectConfig config_;
  std::int64_t lost_after_ns_;
  double surface_sigma_m_;
  int min_points_;
  double min_disparity_px_;
  double turn_rate_radps_;
  std::size_t velocity_window_frames_;
  StereoGeometry geometry_;
  Identity identity_;
  Life life_;
  Frame frame_;
  bool path_restarts_ = false;  ///< With the next frame.
  sfm::BodyReconstruction body_;
  trajectory::ObjectMotion motion_;
  trajectory::BoxEstimator box_;
  ObjectRecogniser recogniser_;
};

}  // namespace kinetrace::pipeline
