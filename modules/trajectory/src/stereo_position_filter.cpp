#include "kinetrace/trajectory/stereo_position_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace kinetrace::trajectory {
namespace {

constexpr double kStartSpeedSigma_mps = 5.0;
constexpr double kRestSpeedSigma_mps = 0.05;
constexpr double kRestAcceleration_mps2 = 0.1;
constexpr double kGate = 16.3;        // 99.9 % of chi-square with three degrees of freedom.
constexpr double kMotionGate = 13.8;  // The same with two.
constexpr double kNoGate = std::numeric_limits<double>::infinity();
constexpr int kMaxSkipped = 3;
constexpr int kIterations = 3;
constexpr double kMinDepth_m = 0.1;
// Points of one object err together: more than a few features do not sharpen their median.
constexpr int kMaxIndependentFeatures = 4;

/// (u_left, v, disparity) of a point in the camera frame, and its derivative there.
struct Prediction {
  Eigen::Vector3d uvd_px;
  Eigen::Matrix3d derivative;
};

Prediction predict_stereo(const StereoGeometry& g, const Eigen::Vector3d& p) {
  const double inv_z = 1.0 / p.z();
  const double bf = g.fx_px * g.baseline_m;
  Prediction out;
  out.uvd_px << g.fx_px * p.x() * inv_z + g.cx_px, g.fy_px * p.y() * inv_z + g.cy_px, bf * inv_z;
  out.derivative << g.fx_px * inv_z, 0.0, -g.fx_px * p.x() * inv_z * inv_z,  //
      0.0, g.fy_px * inv_z, -g.fy_px * p.y() * inv_z * inv_z,                //
      0.0, 0.0, -bf * inv_z * inv_z;
  return out;
}

}  // namespace

void StereoPositionFilter::start(std::int64_t timestamp_ns, const Eigen::Vector3d& position_m,
                                 const Eigen::Vector3d& velocity_mps, const Eigen::Matrix3d& position_covariance,
                                 bool at_rest) noexcept {
  initialised_ = true;
  at_rest_ = at_rest;
  skipped_ = 0;
  timestamp_ns_ = timestamp_ns;
  position_ = position_m;
  velocity_ = velocity_mps;
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = position_covariance;
  const double speed_sigma_mps = at_rest ? kRestSpeedSigma_mps : kStartSpeedSigma_mps;
  covariance_.bottomRightCorner<3, 3>().diagonal().setConstant(speed_sigma_mps * speed_sigma_mps);
}

Matrix6d StereoPositionFilter::process_noise(double dt_s) const noexcept {
  const double acceleration_mps2 = at_rest_ ? kRestAcceleration_mps2 : config_.max_acceleration_mps2;
  const double variance = acceleration_mps2 * acceleration_mps2;
  const Eigen::Matrix3d view = Eigen::Matrix3d::Identity();
  Matrix6d noise;
  noise << 0.25 * dt_s * dt_s * view, 0.5 * dt_s * view, 0.5 * dt_s * view, view;
  return variance * dt_s * dt_s * noise;
}

void StereoPositionFilter::predict(std::int64_t timestamp_ns) noexcept {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  if (initialised_ && dt_s <= 0.0) {
    return;
  }
  timestamp_ns_ = timestamp_ns;
  if (!initialised_) {
    return;
  }
  position_ += dt_s * velocity_;
  Matrix6d transition = Matrix6d::Identity();
  transition.topRightCorner<3, 3>().diagonal().setConstant(dt_s);
  covariance_ = transition * covariance_ * transition.transpose() + process_noise(dt_s);
}

void StereoPositionFilter::restart_at(const Eigen::Vector3d& uvd_px, double sigma_px, const Se3& T_world_cam,
                                      double surface_sigma_m) noexcept {
  const Eigen::Vector3d p_cam = geometry_.triangulate(uvd_px.x(), uvd_px.y(), uvd_px.z());
  const Eigen::Matrix3d per_pixel = T_world_cam.rotation * predict_stereo(geometry_, p_cam).derivative.inverse();
  start(timestamp_ns_, T_world_cam * p_cam, Eigen::Vector3d::Zero(),
        sigma_px * sigma_px * per_pixel * per_pixel.transpose() +
            surface_sigma_m * surface_sigma_m * Eigen::Matrix3d::Identity());
}

bool StereoPositionFilter::update(const Eigen::Vector3d& uvd_px, int features, const Se3& T_world_cam,
                                  double surface_sigma_m) noexcept {
  jumped_ = false;
  if (features < 1 || !uvd_px.allFinite() || uvd_px.z() <= 0.0) {
    return false;
  }
  const double sigma_px =
      config_.stereo_sigma_px / std::sqrt(static_cast<double>(std::min(features, kMaxIndependentFeatures)));
  if (!initialised_) {
    restart_at(uvd_px, sigma_px, T_world_cam, surface_sigma_m);
    return true;
  }
  const std::optional<StereoCorrection> found = find_correction(uvd_px, sigma_px, T_world_cam, surface_sigma_m);
  if (!found) {
    if (++skipped_ < kMaxSkipped) {
      return false;
    }
    restart_at(uvd_px, sigma_px, T_world_cam, surface_sigma_m);
    jumped_ = true;
    return true;
  }
  skipped_ = 0;
  position_ += found->correction.head<3>();
  velocity_ += found->correction.tail<3>();
  // Joseph's form stays symmetric and positive.
  Matrix6d keep = Matrix6d::Identity();
  keep.leftCols<3>() -= found->gain * found->slope;
  covariance_ = keep * covariance_ * keep.transpose() + found->gain * found->noise * found->gain.transpose();
  return true;
}

// Iterated: the measurement is linearised where the correction before it leads.
std::optional<StereoPositionFilter::StereoCorrection> StereoPositionFilter::find_correction(
    const Eigen::Vector3d& uvd_px, double sigma_px, const Se3& T_world_cam, double surface_sigma_m) const noexcept {
  const Se3 T_cam_world = T_world_cam.inverse();
  StereoCorrection found;
  Eigen::Vector3d at = position_;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector3d p_cam = T_cam_world * at;
    if (!(p_cam.z() > kMinDepth_m)) {
      return std::nullopt;
    }
    const Prediction predicted = predict_stereo(geometry_, p_cam);
    found.slope = predicted.derivative * T_cam_world.rotation;
    found.noise = sigma_px * sigma_px * Eigen::Matrix3d::Identity() +
                  surface_sigma_m * surface_sigma_m * found.slope * found.slope.transpose();
    const Eigen::Matrix3d spread =
        found.slope * covariance_.topLeftCorner<3, 3>() * found.slope.transpose() + found.noise;
    const Eigen::Vector3d innovation = uvd_px - predicted.uvd_px - found.slope * (position_ - at);
    const Eigen::LDLT<Eigen::Matrix3d> solver(spread);
    if (i == 0 && !(innovation.dot(solver.solve(innovation)) <= kGate)) {
      return std::nullopt;
    }
    found.gain = solver.solve(found.slope * covariance_.topRows<3>()).transpose();
    found.correction = found.gain * innovation;
    at = position_ + found.correction.head<3>();
  }
  return found;
}

void StereoPositionFilter::update_direction(const Eigen::Vector2d& uv_px, const Se3& T_world_cam,
                                            double sigma_m) noexcept {
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * position_;
  if (!initialised_ || p_cam.z() <= kMinDepth_m) {
    return;
  }
  const Prediction predicted = predict_stereo(geometry_, p_cam);
  Eigen::Matrix<double, 2, 6> slope = Eigen::Matrix<double, 2, 6>::Zero();
  slope.leftCols<3>() = predicted.derivative.topRows<2>() * T_world_cam.rotation.transpose();
  const Eigen::Matrix2d noise = config_.stereo_sigma_px * config_.stereo_sigma_px * Eigen::Matrix2d::Identity() +
                                sigma_m * sigma_m * slope * slope.transpose();
  correct(uv_px - predicted.uvd_px.head<2>(), slope, noise, kNoGate);
}

void StereoPositionFilter::update_motion(const ImageMotion& motion, double interval_s, const Se3& T_world_cam,
                                         const Se3& T_world_cam_before) noexcept {
  const double depth_m = (T_world_cam.inverse() * position_).z();
  if (!initialised_ || motion.features < 1 || interval_s <= 0.0 || depth_m <= kMinDepth_m) {
    return;
  }
  // What is seen lies in its own direction, as far away as the object; where it was before follows from the velocity.
  const Eigen::Vector3d ray((motion.now_px.x() - geometry_.cx_px) / geometry_.fx_px,
                            (motion.now_px.y() - geometry_.cy_px) / geometry_.fy_px, 1.0);
  const Eigen::Vector3d seen_m = T_world_cam * Eigen::Vector3d(depth_m * ray);
  const Eigen::Vector3d before_cam_m = T_world_cam_before.inverse() * (seen_m - interval_s * velocity_);
  if (before_cam_m.z() <= kMinDepth_m) {
    return;
  }
  const Prediction predicted = predict_stereo(geometry_, before_cam_m);
  const Eigen::Matrix<double, 2, 3> per_metre =
      predicted.derivative.topRows<2>() * T_world_cam_before.rotation.transpose();
  Eigen::Matrix<double, 2, 6> slope;
  slope << per_metre * T_world_cam.rotation * ray * T_world_cam.rotation.col(2).transpose(), -interval_s * per_metre;
  const double sigma_px =
      config_.stereo_sigma_px / std::sqrt(static_cast<double>(std::min(motion.features, kMaxIndependentFeatures)));
  correct(motion.before_px - predicted.uvd_px.head<2>(), slope, sigma_px * sigma_px * Eigen::Matrix2d::Identity(),
          kMotionGate);
}

void StereoPositionFilter::correct(const Eigen::Vector2d& innovation, const Eigen::Matrix<double, 2, 6>& slope,
                                   const Eigen::Matrix2d& noise, double gate) noexcept {
  const Eigen::LDLT<Eigen::Matrix2d> solver(slope * covariance_ * slope.transpose() + noise);
  if (innovation.dot(solver.solve(innovation)) > gate) {
    return;
  }
  const Eigen::Matrix<double, 6, 2> gain = solver.solve(slope * covariance_).transpose();
  const Vector6d correction = gain * innovation;
  position_ += correction.head<3>();
  velocity_ += correction.tail<3>();
  // Joseph's form stays symmetric and positive.
  const Matrix6d keep = Matrix6d::Identity() - gain * slope;
  covariance_ = keep * covariance_ * keep.transpose() + gain * noise * gain.transpose();
}

}  // namespace kinetrace::trajectory
