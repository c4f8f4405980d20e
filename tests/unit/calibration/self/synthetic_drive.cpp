#include "synthetic_drive.hpp"

#include <cmath>
#include <random>

namespace kinetrace::self_calibration::test {
namespace {

constexpr double kNear_m = 4.0;
constexpr double kFar_m = 40.0;

class Drive {
 public:
  Drive(const RigModel& rig, const DriveOptions& options) : rig_(rig), options_(options) {}

  TrackWindow window() {
    TrackWindow window;
    for (std::size_t frame = 0; frame < options_.frames; ++frame) {
      window.places.push_back(frame);
    }
    const std::vector<Se3> poses = path();
    for (std::size_t i = 0; i < options_.points; ++i) {
      const bool moves = uniform(0.0, 1.0) < options_.outlier_share;
      Track track = follow(poses, point(), moves ? Eigen::Vector3d(0.15, 0.0, -0.1) : Eigen::Vector3d::Zero());
      if (track.observations.size() > 3) {
        window.tracks.push_back(std::move(track));
      }
    }
    return window;
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  Eigen::Vector3d point() {
    const Eigen::Vector2d pixel(uniform(10.0, rig_.size.width_px - 10.0), uniform(10.0, rig_.size.height_px - 10.0));
    const Eigen::Vector3d ray = unproject(rig_.lens[0], rig_.size, pixel).homogeneous();
    const double depth =
        options_.world == World::kWall ? 8.0 / (1.0 + 0.3 * ray.x()) : 1.0 / uniform(1.0 / kFar_m, 1.0 / kNear_m);
    return depth * ray;
  }

  /// T_camera_world.
  std::vector<Se3> path() {
    std::vector<Se3> poses(options_.frames);
    const Eigen::Vector3d axis = Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    const Eigen::Vector3d step(uniform(-0.1, 0.1), uniform(-0.05, 0.05), -uniform(0.15, 0.3));
    for (std::size_t k = 1; k < poses.size(); ++k) {
      const double turn = options_.motion == Motion::kRest ? 0.0 : 0.012 * static_cast<double>(k);
      const Eigen::Vector3d travelled =
          options_.motion == Motion::kTravel ? Eigen::Vector3d(static_cast<double>(k) * step) : Eigen::Vector3d::Zero();
      poses[k] = {so3_exp(turn * axis), travelled};
    }
    return poses;
  }

  Track follow(const std::vector<Se3>& poses, const Eigen::Vector3d& start, const Eigen::Vector3d& step) {
    Track track;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const Eigen::Vector3d p_left = poses[k] * (start + static_cast<double>(k) * step);
      const std::array<Eigen::Vector3d, 2> p_view{p_left, rig_.T_right_left() * p_left};
      for (std::size_t view = 0; view < 2; ++view) {
        Eigen::Vector2d pixel;
        project(rig_.lens[view].data(), rig_.size, p_view[view].data(), pixel.data());
        const bool is_seen = p_view[view].z() > 0.5 && pixel.minCoeff() > 2.0 && pixel.x() < rig_.size.width_px - 3 &&
                             pixel.y() < rig_.size.height_px - 3;
        if (!is_seen && (view == 0 || k == 0)) {
          return track.observations.size() < 2 ? Track{} : track;
        }
        if (is_seen) {
          const Eigen::Vector2d noise(normal_(random_), normal_(random_));
          track.observations.push_back(
              {static_cast<std::uint8_t>(view), static_cast<std::uint16_t>(k), pixel + options_.noise_px * noise});
        }
      }
    }
    return track;
  }

  const RigModel& rig_;
  DriveOptions options_;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

}  // namespace

RigModel distorted_rig() {
  RigModel rig = plain_rig({640, 480}, 0.3, 420.0);
  rig.lens[0] = {std::log(420.0 / 640), -0.003, 0.008, -0.006, -0.19, 0.05, 0.001, -0.0006, -0.006};
  rig.lens[1] = {std::log(421.0 / 640), -0.002, -0.005, 0.007, -0.185, 0.048, -0.0007, 0.0009, -0.005};
  rig.mount = {0.009, -0.02, -0.013, 0.01, 0.015};
  return rig;
}

std::vector<TrackWindow> synthetic_drive(const RigModel& rig, const DriveOptions& options) {
  Drive drive(rig, options);
  std::vector<TrackWindow> windows;
  for (std::size_t w = 0; w < options.windows; ++w) {
    windows.push_back(drive.window());
  }
  return windows;
}

}  // namespace kinetrace::self_calibration::test
