#include "receiver.hpp"

#include <cmath>

#include "alignment_model.hpp"

namespace kinetrace::geo::test {
namespace {

constexpr double kRate_hz = 10.0;
constexpr std::int64_t kStart_ns = 1'600'000'000'000'000'000;

/// World: x right, y down, z forward.
Eigen::Matrix3d looking(double heading_rad, double pitch_rad) {
  return so3_exp(heading_rad * Eigen::Vector3d::UnitY()) * so3_exp(pitch_rad * Eigen::Vector3d::UnitX());
}

}  // namespace

std::vector<PathPose> drive(const PathShape& shape) {
  std::vector<PathPose> path;
  const double step_m = shape.speed_mps / kRate_hz;
  constexpr int kSubsteps = 20;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int i = 0; i * step_m <= shape.length_m; ++i) {
    const double distance_m = i * step_m;
    const std::int64_t time_ns = kStart_ns + std::llround(i * 1e9 / kRate_hz);
    path.push_back({time_ns, {looking(shape.heading_rad(distance_m), shape.pitch_rad(distance_m)), place}});
    for (int k = 0; k < kSubsteps; ++k) {
      const double at_m = distance_m + (k + 0.5) * step_m / kSubsteps;
      place += looking(shape.heading_rad(at_m), shape.pitch_rad(at_m)).col(2) * step_m / kSubsteps;
    }
  }
  return path;
}

PathShape town() {
  PathShape shape;
  // Quarter turns of 20 m after straight stretches of 55 m: right, right, left.
  shape.heading_rad = [](double distance_m) {
    double heading_rad = 0.0;
    int turn = 0;
    for (double begin_m = 55.0; begin_m < distance_m; begin_m += 75.0, ++turn) {
      heading_rad += (turn == 2 ? -1.0 : 1.0) * M_PI_2 * std::min((distance_m - begin_m) / 20.0, 1.0);
    }
    return heading_rad;
  };
  return shape;
}

PathShape flight() {
  PathShape shape;
  shape.heading_rad = [](double distance_m) { return 2.0 * M_PI * distance_m / 150.0; };
  shape.pitch_rad = [](double distance_m) { return 0.6 * std::sin(2.0 * M_PI * distance_m / 110.0); };
  return shape;
}

std::vector<Fix> receive(const std::vector<PathPose>& path, const Receiver& receiver, std::mt19937& random) {
  AlignmentConfig config;
  config.lever_arm_m = receiver.lever_arm_m;
  const AntennaPath antenna(path, config);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto noise = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  std::vector<Fix> fixes;
  Eigen::Vector3d error = noise();
  // At its own times, so that fixes do not coincide with camera poses.
  for (double at_s = 0.037; antenna.begin_ns() + std::llround(at_s * 1e9) <= antenna.end_ns();
       at_s += 1.0 / receiver.rate_hz) {
    const std::int64_t camera_ns = antenna.begin_ns() + std::llround(at_s * 1e9);
    const Eigen::Vector3d place = receiver.T_map_world * antenna.at(camera_ns)->world_m;
    error = receiver.correlation * error + std::sqrt(1.0 - receiver.correlation * receiver.correlation) * noise();
    Fix fix{camera_ns - std::llround(receiver.time_offset_s * 1e9), place + receiver.noise_m * error,
            Eigen::Vector3d::Constant(receiver.noise_m)};
    if (uniform(random) < receiver.outlier_share) {
      fix.enu_m += receiver.outlier_m * noise();
    }
    fixes.push_back(fix);
  }
  return fixes;
}

Se3 any_placement(std::mt19937& random, double tilt_rad) {
  std::uniform_real_distribution<double> angle(-M_PI, M_PI);
  std::uniform_real_distribution<double> tilt(-tilt_rad, tilt_rad);
  std::uniform_real_distribution<double> place(-500.0, 500.0);
  const Eigen::Matrix3d heading = so3_exp(angle(random) * Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d tilted = so3_exp(Eigen::Vector3d(tilt(random), tilt(random), 0.0));
  return {heading * tilted * level_rotation(), {place(random), place(random), place(random) / 10.0}};
}

}  // namespace kinetrace::geo::test
