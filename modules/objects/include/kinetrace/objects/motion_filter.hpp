// Motion of an object between frames and during occlusion: interacting multiple model filter (Blom, Bar-Shalom 1988;
// Bar-Shalom, Li, Kirubarajan 2001, sec. 11.6), at rest or at constant turn rate and velocity.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/objects/measurements.hpp"

namespace kinetrace::objects {

/// Standard deviation of an unknown velocity: town traffic.
inline constexpr double kUnknownVelocitySigma_mps = 5.0;

struct MotionNoise {
  MotionPrior prior = {};
  double stereo_sigma_px = 0.5;  ///< Standard deviation of the image coordinates of a stereo position.
};

/// A pose with the covariance of its rotation (rad) and of its origin's position (m), world axes.
struct UncertainPose {
  Se3 T_world_obj;
  Matrix6d covariance = Matrix6d::Zero();
};

/// World axes.
struct UncertainPosition {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Initial state of the filter.
struct MotionStart {
  std::int64_t timestamp_ns = 0;
  UncertainPose pose;
  Vector6d velocity = Vector6d::Zero();                           ///< In the body's own axes (rad/s, m/s).
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< Of the linear velocity, world axes.
  double moving_probability = 0.5;                                ///< Probability of moving.
  Eigen::Matrix3d part_covariance_m2 = Eigen::Matrix3d::Zero();   ///< See VisiblePart.
};

/// Two models of one object's motion and their probabilities. The object's pose is that of the more probable model; the
/// mean of both is right under neither. The rotation is predicted, never measured. No heap; same input, same output,
/// bit for bit.
class MotionFilter {
 public:
  static constexpr int kStates = 9;
  /// Position (m), velocity (m/s), and displacement (m) of the visible part's centre from where it was when the filter
  /// started; world axes. The displacement is a Gauss-Markov process: an error that stays from frame to frame.
  using State = Eigen::Matrix<double, kStates, 1>;
  using StateCovariance = Eigen::Matrix<double, kStates, kStates>;

  MotionFilter(const MotionNoise& noise, const StereoGeometry& geometry) : noise_(noise), geometry_(geometry) {}

  void reset() noexcept { initialised_ = false; }
  /// Normal of the ground, world axes; nothing where the ground is not known.
  void set_vertical(const std::optional<Eigen::Vector3d>& vertical) noexcept { vertical_ = vertical; }
  [[nodiscard]] bool initialised() const noexcept { return initialised_; }
  void start(const MotionStart& start) noexcept;
  /// Restarts at the stereo position with an unknown velocity; the rotation stays.
  void restart_at(const StereoPosition& measured, const Se3& T_world_cam) noexcept;

  /// Predicts the state at `timestamp_ns`. No effect if time does not advance.
  void predict(std::int64_t timestamp_ns) noexcept;

  // Updates at the time of the last `predict` or `start` (iterated extended Kalman filter). An invalid measurement, or
  // one outside the gates of both models (chi-square, 99.9 %; none for bearings), leaves pose and velocity as they are
  // and returns false.
  // The measurement noise is that of image coordinates, so the uncertainty of depth grows with its square.

  bool update(const StereoPosition& measured, const Se3& T_world_cam) noexcept;
  bool update(const Bearing& measured, const Se3& T_world_cam) noexcept;
  bool update(const ImageMotion& measured, const Se3& T_world_cam) noexcept;
  /// Log density of `measured`, per cubic pixel of (u_left, v, disparity), over both models by their probabilities.
  /// Nothing behind the camera.
  [[nodiscard]] std::optional<double> log_likelihood(const StereoPosition& measured,
                                                     const Se3& T_world_cam) const noexcept;

  /// Probability of moving.
  [[nodiscard]] double moving_probability() const noexcept { return model_[kMoving].probability; }
  [[nodiscard]] bool at_rest() const noexcept { return moving_probability() < 0.5; }
  [[nodiscard]] Se3 pose() const noexcept { return model_[likelier()].pose(); }
  [[nodiscard]] Eigen::Vector3d velocity_mps() const noexcept { return model_[likelier()].state.segment<3>(3); }
  [[nodiscard]] Matrix6d pose_covariance() const noexcept { return pose_covariance(model_[likelier()], timestamp_ns_); }
  // Predictions without a measurement.

  [[nodiscard]] UncertainPose predicted(std::int64_t timestamp_ns) const noexcept;
  /// Centre of the visible part.
  [[nodiscard]] UncertainPosition predicted_part(std::int64_t timestamp_ns, const VisiblePart& part) const noexcept;

 private:
  static constexpr std::size_t kStationary = 0;
  static constexpr std::size_t kMoving = 1;

  struct Model {
    double probability = 0.5;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< World from object.
    State state = State::Zero();
    StateCovariance covariance = StateCovariance::Zero();

    [[nodiscard]] Se3 pose() const noexcept { return {rotation, state.head<3>()}; }
  };
  using Models = std::array<Model, 2>;

  [[nodiscard]] std::size_t likelier() const noexcept { return at_rest() ? kStationary : kMoving; }
  void set_part(const VisiblePart& part) noexcept;
  [[nodiscard]] Matrix6d pose_covariance(const Model& model, std::int64_t timestamp_ns) const noexcept;
  [[nodiscard]] Models predicted_models(std::int64_t timestamp_ns) const noexcept;
  /// `models`, where the visible part's centre may be as far from its place as `part` says.
  [[nodiscard]] Models with_part(Models models, const VisiblePart& part) const noexcept;
  /// Density of no velocity after `interval_s`, relative to the most likely velocity's: 0 to 1.
  [[nodiscard]] double rest_likelihood(double interval_s) const noexcept;
  [[nodiscard]] Models mix(double interval_s) const noexcept;
  void propagate(Models& models, double interval_s) const noexcept;
  /// Updates each model, linearised about its own state.
  template <typename Measurement>
  bool update_models(const Measurement& measured, const Se3& T_world_cam, double gate) noexcept;

  /// `observation`: linearised about the model's state.
  template <typename Linearised, typename Observe>
  static void correct(Model& model, Linearised observation, const Observe& observed_at);

  MotionNoise noise_;
  StereoGeometry geometry_;
  std::optional<Eigen::Vector3d> vertical_;
  bool initialised_ = false;
  std::int64_t timestamp_ns_ = 0;
  double interval_s_ = 0.0;  ///< Of the last prediction.
  Models model_;
  Eigen::Matrix3d part_covariance_m2_ = Eigen::Matrix3d::Zero();  ///< Stationary covariance of the displacement.
  Eigen::Vector3d turn_rate_radps_ = Eigen::Vector3d::Zero();     ///< Body axes.
  Eigen::Matrix3d start_rotation_covariance_ = Eigen::Matrix3d::Zero();
  std::int64_t start_timestamp_ns_ = 0;
};

}  // namespace kinetrace::objects
