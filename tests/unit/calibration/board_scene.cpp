#include "board_scene.hpp"

#include <cmath>

namespace kinetrace::calibration::test {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

hal::CameraModel true_camera(Lens lens, double scale, double focal_px, double cx_px, double cy_px) {
  hal::CameraModel camera{.lens = model_of(lens),
                          .width_px = static_cast<int>(scale * kWidth),
                          .height_px = static_cast<int>(scale * kHeight),
                          .fx_px = scale * focal_px,
                          .fy_px = scale * focal_px * 1.002,
                          .cx_px = scale * (cx_px + 0.5) - 0.5,
                          .cy_px = scale * (cy_px + 0.5) - 0.5};
  switch (lens) {
    case Lens::kRadialTangential: camera.distortion = {-0.21, 0.06, 0.0004, -0.0006}; break;
    case Lens::kRadialTangential5: camera.distortion = {-0.25, 0.09, 0.0004, -0.0006, -0.02}; break;
    case Lens::kRational: camera.distortion = {0.35, -0.12, 0.0002, -0.0003, 0.01, 0.62, -0.05, 0.02}; break;
    case Lens::kFisheye: camera.distortion = {0.012, -0.008, 0.003, -0.0006}; break;
  }
  return camera;
}

}  // namespace

hal::RigCalibration true_rig(Lens lens, double scale) {
  const double focal_px = lens == Lens::kFisheye ? 255.0 : 480.0;
  hal::RigCalibration rig;
  rig.source = "truth";
  rig.left = true_camera(lens, scale, focal_px, 324.3, 236.1);
  rig.right = true_camera(lens, scale, focal_px * 1.007, 314.8, 243.6);
  rig.T_right_left.rotation = so3_exp({0.012, -0.021, 0.006});
  rig.T_right_left.translation = -(rig.T_right_left.rotation * Eigen::Vector3d(0.12, 0.0011, -0.0007));
  return rig;
}

std::vector<Se3> board_poses(const hal::RigCalibration& rig, const Target& target, const Motion& motion,
                             std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  const Eigen::Vector2d extent = target.extent_m();
  Eigen::Vector3d first = target.points_m.front();
  for (const Eigen::Vector3d& point : target.points_m) {
    first = first.cwiseMin(point);
  }
  const Eigen::Vector3d middle = first + Eigen::Vector3d(extent.x() / 2, extent.y() / 2, 0.0);
  std::vector<Se3> poses;
  for (int i = 0; i < motion.views; ++i) {
    const double depth_m = motion.near_m + (motion.far_m - motion.near_m) * (within(random) + 1) / 2;
    const Eigen::Vector2d px(rig.left.cx_px + within(random) * motion.spread * 0.42 * rig.left.width_px,
                             rig.left.cy_px + within(random) * motion.spread * 0.42 * rig.left.height_px);
    const Eigen::Vector2d ray = normalised_ray(rig.left, px).value_or(Eigen::Vector2d::Zero());
    const Eigen::Vector3d centre(ray.x() * depth_m + 0.06, ray.y() * depth_m, depth_m);
    const Eigen::Matrix3d R =
        so3_exp({motion.max_tilt_rad * within(random), motion.max_tilt_rad * within(random), 0.3 * within(random)});
    poses.push_back({R, centre - R * middle});
  }
  return poses;
}

std::vector<BoardView> ideal_views(const hal::RigCalibration& rig, const Target& target, const std::vector<Se3>& poses,
                                   double noise_px, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, noise_px);
  const auto see = [&](const hal::CameraModel& camera, const Se3& T_cam_board) {
    std::vector<Corner> corners;
    for (std::size_t i = 0; i < target.points_m.size(); ++i) {
      const Eigen::Vector3d p_cam = T_cam_board * target.points_m[i];
      const Eigen::Vector2d px = camera.project(p_cam);
      const bool inside = px.x() >= 0 && px.y() >= 0 && px.x() <= camera.width_px - 1 && px.y() <= camera.height_px - 1;
      if (p_cam.z() > 0.05 && inside) {
        corners.push_back({static_cast<int>(i), px + Eigen::Vector2d(noise(random), noise(random))});
      }
    }
    return corners;
  };
  std::vector<BoardView> views;
  for (const Se3& pose : poses) {
    views.push_back({.frame_index = static_cast<std::int64_t>(views.size()),
                     .left = see(rig.left, pose),
                     .right = see(rig.right, rig.T_right_left * pose)});
  }
  return views;
}

}  // namespace kinetrace::calibration::test
