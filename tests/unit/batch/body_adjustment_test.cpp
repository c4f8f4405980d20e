// A vehicle at constant velocity, whose points are seen with noise that lasts over frames.
#include "body_adjustment.hpp"

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::batch {
namespace {

constexpr std::uint32_t kFrames = 60;
constexpr std::uint32_t kPoints = 40;
constexpr std::int64_t kInterval_ns = 100'000'000;
constexpr double kNoise_px = 0.1;

class Drive {
 public:
  /// `persistence`: autocorrelation of a point's noise from frame to frame.
  explicit Drive(double persistence) {
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector3d> noise;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      points.emplace_back(2.0 * uniform(random), 0.7 * uniform(random), 0.9 * uniform(random));
      noise.emplace_back(gauss(random), gauss(random), gauss(random));
    }
    for (std::uint32_t k = 0; k < kFrames; ++k) {
      const Se3 T_world_body{Eigen::Matrix3d::Identity(), {-6.0 + 0.2 * k, 0.5, 18.0 - 0.1 * k}};
      truth_.push_back(T_world_body.inverse());
      T_world_cam_.emplace_back();
      timestamps_ns_.push_back(k * kInterval_ns);
      at_rest_.push_back(0);
      for (std::uint32_t i = 0; i < kPoints; ++i) {
        const double fresh = std::sqrt(1.0 - persistence * persistence);
        noise[i] = persistence * noise[i] + fresh * Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
        const Eigen::Vector3d px = geometry_.project(T_world_body * points[i]) + kNoise_px * noise[i];
        seen_.push_back({k, i, px.cast<float>()});
      }
    }
  }

  /// Error of the body's motion from frame to frame, root mean square, metres.
  [[nodiscard]] double step_error_m() const {
    BodyProblem problem{
        .geometry = geometry_,
        .T_body_cam = truth_,
        .seen = seen_,
        .fixed_frames = {},
        .motion =
            refinement::BatchMotion{.T_world_cam = T_world_cam_, .timestamps_ns = timestamps_ns_, .at_rest = at_rest_},
        .measured_poses = {},
        .measured_steps = {}};
    problem.fixed_frames = {0};
    EXPECT_TRUE(adjust_body(problem, {}));
    double squares = 0.0;
    for (std::size_t k = 1; k < kFrames; ++k) {
      const auto step = [k](const std::vector<Se3>& T_body_cam) { return T_body_cam[k].inverse() * T_body_cam[k - 1]; };
      squares += (step(problem.T_body_cam).translation - step(truth_).translation).squaredNorm();
    }
    return std::sqrt(squares / (kFrames - 1));
  }

 private:
  StereoGeometry geometry_ = test::street_rig();
  std::vector<Se3> truth_;
  std::vector<Se3> T_world_cam_;
  std::vector<std::int64_t> timestamps_ns_;
  std::vector<std::uint8_t> at_rest_;
  std::vector<SeenPoint> seen_;
};

// As many observations of a point as share one error count as one, beside the prior of constant velocity.
TEST(AdjustBody, NoiseThatLastsDoesNotBendThePath) {
  EXPECT_LT(Drive(0.8).step_error_m(), 0.0078) << "0.0089 if each counts alone";
  EXPECT_LT(Drive(0.0).step_error_m(), 0.016);
}

}  // namespace
}  // namespace kinetrace::batch
