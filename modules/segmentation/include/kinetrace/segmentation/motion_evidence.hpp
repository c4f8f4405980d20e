// How fast each feature moves through the world, and how sure that is.
#pragma once

#include <array>
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

/// Velocity of one feature relative to the static world; axes of the frame that reset() began with.
struct FeatureMotion {
  bool known = false;  ///< A constant velocity explains the feature's recent observations.
  float depth_m = 0.F;
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();   ///< Of the velocity, from image noise alone.
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< Its inverse.
  Eigen::Matrix3f systematic = Eigen::Matrix3f::Zero();   ///< Covariance that neighbours share: ego motion, disparity.
  float static_chi2 = 0.F;                                ///< velocity^T information velocity.
};

/// Keeps each feature's stereo observations of the last `window_frames` frames as points of the static world, each with
/// the information matrix J^T J / sigma^2 of its reprojection (uL, v, uR): along the ray a point is known far less well
/// than across it. A weighted line fit gives position and velocity; over a window the signal grows with time while the
/// noise does not. A single observation that does not fit is left out, a feature with more of them has no say. Nor has
/// one that would look the same where it ought to be at rest: on repetitive texture (road markings, fences) a track may
/// jump from one element to the next in every frame, and then seems to travel with the camera.
class MotionEvidence {
 public:
  static constexpr int kMaxWindowFrames = 16;

  MotionEvidence() = default;
  MotionEvidence(const MotionConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena);

  /// Adds a frame; the result is parallel to `features` and lives until the next call.
  /// `left` may be empty: then repetitive texture goes unnoticed. `T_prev_cam`: this frame's left camera in the
  /// previous frame's; ignored for the first frame after reset().
  std::span<const FeatureMotion> update(std::span<const Feature> features, GrayView left, const Se3& T_prev_cam,
                                        std::int64_t timestamp_ns);
  void reset() noexcept;

  /// Of the camera, between the last two frames; 0 before.
  [[nodiscard]] double ego_speed_mps() const noexcept { return ego_speed_mps_; }

 private:
  struct Observation {
    std::uint32_t frame = 0;                  ///< 0 = none.
    Eigen::Vector3f offset_m{0.F, 0.F, 0.F};  ///< World position minus the slot's anchor.
    std::array<float, 6> information{};       ///< Upper triangle, row by row.
  };
  struct Slot {
    std::uint32_t feature_id = 0;
    Eigen::Vector3d anchor_m{0.0, 0.0, 0.0};
    std::array<Observation, kMaxWindowFrames> ring{};
  };
  struct Sums;
  struct Fit;

  void observe(const Feature& feature, Slot& slot) const;
  [[nodiscard]] Observation make_observation(double u_left_px, double v_px, double disparity_px, const Se3& T_world_cam,
                                             std::uint32_t frame, const Eigen::Vector3d& anchor_m) const;
  [[nodiscard]] Sums sum_window(const Slot& slot) const;
  [[nodiscard]] FeatureMotion fit_motion(const Feature& feature, const Slot& slot) const;
  [[nodiscard]] bool looks_the_same_at_rest(const Feature& feature, const FeatureMotion& motion, GrayView left) const;
  [[nodiscard]] Eigen::Matrix3f systematic_covariance(const Feature& feature, double span_s) const;
  [[nodiscard]] std::size_t ring_index(std::uint32_t frame) const noexcept {
    return frame % static_cast<std::uint32_t>(config_.window_frames);
  }
  [[nodiscard]] bool in_window(const Observation& observation) const noexcept {
    return observation.frame != 0 && observation.frame + static_cast<std::uint32_t>(config_.window_frames) > frame_;
  }

  MotionConfig config_;
  StereoGeometry geometry_;
  std::uint32_t frame_ = 0;
  Se3 T_world_cam_;
  Se3 T_world_prev_;         ///< The camera one frame ago.
  double interval_s_ = 0.0;  ///< Between the last two frames.
  double ego_speed_mps_ = 0.0;
  std::array<std::int64_t, kMaxWindowFrames> time_ns_{};
  std::span<Slot> slots_;
  FixedVector<FeatureMotion> motions_;
};

}  // namespace kinetrace::segmentation
