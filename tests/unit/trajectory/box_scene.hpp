// Exact scene of a car on the ground and a camera that looks at it.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/trajectory/box_estimator.hpp"

namespace kinetrace::trajectory {

inline constexpr StereoGeometry kCamera{720.0, 720.0, 620.0, 187.0, 0.54, 1242, 375};
inline constexpr double kCameraHeight_m = 1.65;

/// The object's frame is the world's: the car stands at its place, the camera moves.
struct CarScene {
  Box3 car{{0.0, -0.75, 0.0}, {4.3, 1.5, 1.8}, 0.5 * std::numbers::pi};  // On y = 0, along -z.
  std::mt19937 random{1};
  double edge_px = 0.0;  ///< Noise of the mask's edges, standard deviation.
  double point_m = 0.0;  ///< Noise of points along the ray.

  /// From `azimuth_rad` round the car, 0 = from +x, at `distance_m`, looking at its middle.
  [[nodiscard]] Se3 camera_at(double azimuth_rad, double distance_m) const {
    const Eigen::Vector3d from(std::cos(azimuth_rad), 0.0, -std::sin(azimuth_rad));
    Se3 T_obj_cam;
    T_obj_cam.translation = car.center_m + distance_m * from;
    T_obj_cam.translation.y() = -kCameraHeight_m;
    const Eigen::Vector3d forward = -from;
    T_obj_cam.rotation.col(0) = Eigen::Vector3d::UnitY().cross(forward);
    T_obj_cam.rotation.col(1) = Eigen::Vector3d::UnitY();
    T_obj_cam.rotation.col(2) = forward;
    return T_obj_cam;
  }

  [[nodiscard]] MaskEdges edges_from(const Se3& T_obj_cam) {
    std::normal_distribution<double> noise(0.0, edge_px);
    MaskEdges edges{{1e9, -1e9, 1e9, -1e9}, {}};
    for (const Eigen::Vector3d& corner : car.corners()) {
      // Real bodies are rounded.
      const Eigen::Vector3d uv = kCamera.project(T_obj_cam.inverse() * (car.center_m + 0.96 * (corner - car.center_m)));
      for (std::size_t i = 0; i < 2; ++i) {
        edges.at_px[2 * i] = std::min(edges.at_px[2 * i], uv[static_cast<Eigen::Index>(i)]);
        edges.at_px[2 * i + 1] = std::max(edges.at_px[2 * i + 1], uv[static_cast<Eigen::Index>(i)]);
      }
    }
    for (double& edge : edges.at_px) {
      edge += edge_px > 0.0 ? noise(random) : 0.0;
    }
    return edges;
  }

  /// Points on the visible faces, a few centimetres behind them.
  [[nodiscard]] std::vector<BodyPoint> points_from(const Se3& T_obj_cam, int count = 40) {
    std::uniform_real_distribution<double> uniform(-0.95, 0.95);
    std::exponential_distribution<double> recess(1.0 / 0.1);
    std::normal_distribution<double> noise(0.0, 1.0);
    const Eigen::Matrix3d axes = car.rotation();
    const Eigen::Vector3d camera = axes.transpose() * (T_obj_cam.translation - car.center_m);
    const Eigen::Vector3d half = 0.5 * car.size_m;
    std::vector<BodyPoint> points;
    while (std::ssize(points) < count) {
      Eigen::Vector3d p{uniform(random), uniform(random), uniform(random)};
      const int axis =
          std::abs(camera.x()) > half.x() && (std::abs(camera.z()) <= half.z() || points.size() % 2 == 0) ? 0 : 2;
      p = p.cwiseProduct(half);
      p[axis] = std::copysign(half[axis] - recess(random), camera[axis]);
      const Eigen::Vector3d at = car.center_m + axes * p;
      const Eigen::Vector3d ray = (at - T_obj_cam.translation).normalized();
      points.push_back({.position_m = (at + point_m * noise(random) * ray).cast<float>()});
    }
    return points;
  }
};

/// Feeds an estimator with frames of a scene.
struct Watcher {
  Arena arena{std::size_t{1} << 16U};
  BoxEstimator box{SizeTable(), kCamera, arena};
  std::int64_t now_ns = 0;
  std::uint16_t class_id = kVehicleClass;

  BoxFrame frame_of(CarScene& scene, const Se3& T_obj_cam, std::span<const BodyPoint> points) {
    now_ns += 100'000'000;
    return {.timestamp_ns = now_ns,
            .class_id = class_id,
            .T_world_obj = {},
            .T_obj_cam = T_obj_cam,
            .edges = scene.edges_from(T_obj_cam),
            .points = points,
            .disparity_sigma_px = 0.1,
            .ground = {Eigen::Vector3d::UnitY(), 0.0, 0.05, 0.01, true},
            .is_rotation_measured = true,
            .heading = {}};
  }
  void watch(CarScene& scene, double azimuth_rad, double distance_m, int frames = 8,
             const std::optional<Heading>& heading = {}) {
    for (int i = 0; i < frames; ++i) {
      const Se3 T_obj_cam = scene.camera_at(azimuth_rad, distance_m);
      const std::vector<BodyPoint> points = scene.points_from(T_obj_cam);
      BoxFrame frame = frame_of(scene, T_obj_cam, points);
      frame.heading = heading;
      box.update(frame);
    }
  }
  [[nodiscard]] Box3 estimate() const { return box.box_in_object(); }
};

/// Yaw difference of two boxes, up to half turns.
inline double turned_rad(const Box3& a, const Box3& b) {
  return std::abs(std::remainder(a.yaw_rad - b.yaw_rad, std::numbers::pi));
}

}  // namespace kinetrace::trajectory
