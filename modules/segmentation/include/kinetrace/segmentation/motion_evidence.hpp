// Velocity of each feature in the world, with its uncertainty.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/config.hpp"

namespace kinetrace::segmentation {

/// Velocity of one feature relative to the static world; axes of the first frame after reset().
struct FeatureMotion {
  bool known = false;  ///< A constant velocity explains three or more recent observations.
  bool fresh = false;  ///< Only two observations: the velocity between them is untested.
  float depth_m = 0.F;
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();   ///< Of the velocity, from image noise alone.
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< Its inverse.
  Eigen::Matrix3f systematic = Eigen::Matrix3f::Zero();   ///< Covariance common to neighbours: ego motion, disparity.
  float static_chi2 = 0.F;                                ///< velocity^T information velocity.
};

/// A Kalman filter for each feature (Franke et al. 2005, "6D-Vision"): position and velocity in the world from its
/// stereo observations (uL, v, uR), so that the uncertainty along the ray is far larger than across. Its memory is
/// fading: the weight of an observation halves after `memory_s`. An outlier is skipped, a second one in a row restarts
/// the filter. A feature is also ignored if it would look the same at the place where it would be at rest: on
/// repetitive texture (road markings, fences) a track may jump from one element to the next in every frame, and then
/// appears to travel with the camera.
class MotionEvidence {
 public:
  MotionEvidence() = default;
  MotionEvidence(const MotionConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena);

  /// Adds a frame; the result is parallel to `features` and lives until the next call. `left` may be empty: then
  /// repetitive texture is not detected. `T_prev_cam`: this frame's left camera in the previous frame's; ignored for
  /// the first frame after reset().
  std::span<const FeatureMotion> update(std::span<const Feature> features, GrayView left, const Se3& T_prev_cam,
                                        std::int64_t timestamp_ns);
  void reset() noexcept;

  /// Speed of the camera between the last two frames; 0 before.
  [[nodiscard]] const Se3& T_world_cam() const noexcept { return T_world_cam_; }
  [[nodiscard]] double ego_speed_mps() const noexcept { return ego_speed_mps_; }

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  struct Slot {
    std::uint32_t feature_id = 0;
    int observations = 0;
    int successive_outliers = 0;
    int outliers = 0;           ///< In total.
    std::int64_t first_ns = 0;  ///< Of the observations the filter holds...
    std::int64_t last_ns = 0;   ///< ...and of the last one, used or not.
    double nis_ratio = 1.0;     ///< Mean NIS over its expectation.
    Eigen::Vector3d anchor_m{0.0, 0.0, 0.0};
    Vector6 state = Vector6::Zero();  ///< World position minus the anchor, velocity.
    Matrix6 covariance = Matrix6::Zero();
  };

  void begin(Slot& slot, const Feature& feature, const Eigen::Vector3d& observation, const Se3& T_world_cam,
             std::int64_t timestamp_ns) const;
  void observe(const Feature& feature, Slot& slot) const;
  void predict(Slot& slot, std::int64_t timestamp_ns) const;
  void correct(Slot& slot, const Eigen::Vector3d& observation, const Se3& T_world_cam) const;
  [[nodiscard]] Eigen::Matrix3d projection_jacobian(const Eigen::Vector3d& p_cam) const;
  [[nodiscard]] FeatureMotion motion_of(const Feature& feature, const Slot& slot) const;
  [[nodiscard]] bool looks_the_same_at_rest(const Feature& feature, const FeatureMotion& motion, GrayView left) const;
  [[nodiscard]] Eigen::Matrix3f systematic_covariance(const Feature& feature, double span_s) const;

  MotionConfig config_;
  StereoGeometry geometry_;
  bool started_ = false;
  std::int64_t now_ns_ = 0;
  std::int64_t before_ns_ = 0;
  Se3 T_world_cam_;
  Se3 T_world_prev_;         ///< The camera one frame ago.
  double interval_s_ = 0.0;  ///< Between the last two frames.
  double ego_speed_mps_ = 0.0;
  std::span<Slot> slots_;
  FixedVector<FeatureMotion> motions_;
};

}  // namespace kinetrace::segmentation
