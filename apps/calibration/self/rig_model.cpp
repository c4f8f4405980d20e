#include "rig_model.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace kinetrace::self_calibration {
namespace {

hal::CameraModel to_camera(const LensBlock& lens, const ImageSize& size) {
  hal::CameraModel camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.fx_px = size.width_px * std::exp(lens[kLogFocal]);
  camera.fy_px = camera.fx_px * std::exp(lens[kLogAspect]);
  camera.cx_px = size.centre_px().x() + size.width_px * lens[kOffsetX];
  camera.cy_px = size.centre_px().y() + size.width_px * lens[kOffsetY];
  camera.distortion = {lens[kK1], lens[kK2], lens[kP1], lens[kP2], lens[kK3], 0.0, 0.0, 0.0};
  return camera;
}

LensBlock to_lens(const hal::CameraModel& camera) {
  const ImageSize size{camera.width_px, camera.height_px};
  LensBlock lens{};
  lens[kLogFocal] = std::log(camera.fx_px / size.width_px);
  lens[kLogAspect] = std::log(camera.fy_px / camera.fx_px);
  lens[kOffsetX] = (camera.cx_px - size.centre_px().x()) / size.width_px;
  lens[kOffsetY] = (camera.cy_px - size.centre_px().y()) / size.width_px;
  lens[kK1] = camera.distortion[0];
  lens[kK2] = camera.distortion[1];
  lens[kP1] = camera.distortion[2];
  lens[kP2] = camera.distortion[3];
  lens[kK3] = camera.distortion[4];
  return lens;
}

}  // namespace

Se3 RigModel::T_right_left() const {
  Eigen::Vector3d direction;
  baseline_direction(mount.data(), direction.data());
  return {so3_exp({mount[kTurnX], mount[kTurnY], mount[kTurnZ]}), baseline_m * direction};
}

double& RigModel::parameter(int place) {
  const auto p = static_cast<std::size_t>(place);
  constexpr std::size_t kLens = kLensSize;
  return p < kLens ? lens[0][p] : p < 2 * kLens ? lens[1][p - kLens] : mount[p - 2 * kLens];
}

RigModel plain_rig(const ImageSize& size, double baseline_m, double focal_px) {
  RigModel rig;
  rig.size = size;
  rig.baseline_m = baseline_m;
  rig.lens[0][kLogFocal] = rig.lens[1][kLogFocal] = std::log(focal_px / size.width_px);
  return rig;
}

hal::RigCalibration to_calibration(const RigModel& rig) {
  hal::RigCalibration calibration;
  calibration.left = to_camera(rig.lens[0], rig.size);
  calibration.right = to_camera(rig.lens[1], rig.size);
  calibration.T_right_left = rig.T_right_left();
  return calibration;
}

RigModel to_model(const hal::RigCalibration& calibration) {
  RigModel rig;
  rig.size = {calibration.left.width_px, calibration.left.height_px};
  rig.lens = {to_lens(calibration.left), to_lens(calibration.right)};
  const Se3& T = calibration.T_right_left;
  rig.baseline_m = T.translation.norm();
  const Eigen::Vector3d turn = so3_log(T.rotation);
  rig.mount = {turn.x(), turn.y(), turn.z(), T.translation.y() / T.translation.x(),
               T.translation.z() / T.translation.x()};
  return rig;
}

Eigen::Vector2d unproject(const LensBlock& lens, const ImageSize& size, const Eigen::Vector2d& pixel) {
  constexpr double kStep = 1e-6;
  const auto image_of = [&](const Eigen::Vector2d& ray) {
    const Eigen::Vector3d p_cam = ray.homogeneous();
    Eigen::Vector2d at;
    project(lens.data(), size, p_cam.data(), at.data());
    return at;
  };
  const double fx = size.width_px * std::exp(lens[kLogFocal]);
  const Eigen::Vector2d offset(lens[kOffsetX] * size.width_px, lens[kOffsetY] * size.width_px);
  Eigen::Vector2d ray = (pixel - size.centre_px() - offset) / fx;
  for (int i = 0; i < 15; ++i) {
    const Eigen::Vector2d at = image_of(ray);
    Eigen::Matrix2d jacobian;
    jacobian.col(0) = (image_of(ray + Eigen::Vector2d(kStep, 0.0)) - at) / kStep;
    jacobian.col(1) = (image_of(ray + Eigen::Vector2d(0.0, kStep)) - at) / kStep;
    const Eigen::Vector2d step = jacobian.fullPivLu().solve(at - pixel);
    ray -= step;
    if (step.squaredNorm() < 1e-22) {
      break;
    }
  }
  return ray;
}

double inverse_depth(const RigModel& rig, const Eigen::Vector2d& left_px, const Eigen::Vector2d& right_px) {
  const Se3 T_right_left = rig.T_right_left();
  const Eigen::Vector3d left = unproject(rig.lens[0], rig.size, left_px).homogeneous();
  const Eigen::Vector3d right = unproject(rig.lens[1], rig.size, right_px).homogeneous();
  // right ~ R left + inverse_depth t: cross product of both sides with `right`.
  const Eigen::Vector3d turned = right.cross(T_right_left.rotation * left);
  const Eigen::Vector3d shifted = right.cross(T_right_left.translation);
  return -shifted.dot(turned) / shifted.squaredNorm();
}

}  // namespace kinetrace::self_calibration
