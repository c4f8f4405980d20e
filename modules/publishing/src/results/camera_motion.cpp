#include "results/camera_motion.hpp"

namespace kinetrace::publishing {

CameraMotion CameraMotionMeter::update(const PublishedFrame& frame) noexcept {
  const CameraResult& camera = frame.camera;
  if (camera.status != BodyStatus::kTracked) {
    previous_.reset();
    return {};
  }
  CameraMotion motion;
  const std::int64_t elapsed_ns = previous_ ? frame.timestamp_ns - previous_->timestamp_ns : 0;
  if (elapsed_ns > 0 && elapsed_ns <= kMaxPause_ns) {
    const double elapsed_s = static_cast<double>(elapsed_ns) * 1e-9;
    const Eigen::Matrix3d R_cam_world = camera.T_world_cam.rotation.transpose();
    const Eigen::Matrix3d turned = camera.T_world_cam.rotation * previous_->T_world_cam.rotation.transpose();
    motion.is_known = true;
    motion.velocity_mps =
        R_cam_world * (camera.T_world_cam.translation - previous_->T_world_cam.translation) / elapsed_s;
    motion.angular_velocity_radps = R_cam_world * so3_log(turned) / elapsed_s;
    Matrix6d into_camera = Matrix6d::Zero();
    into_camera.topLeftCorner<3, 3>() = R_cam_world;
    into_camera.bottomRightCorner<3, 3>() = R_cam_world;
    motion.covariance =
        into_camera * (camera.covariance + previous_->covariance) * into_camera.transpose() / (elapsed_s * elapsed_s);
  }
  previous_ = {frame.timestamp_ns, camera.T_world_cam, camera.covariance};
  return motion;
}

}  // namespace kinetrace::publishing
