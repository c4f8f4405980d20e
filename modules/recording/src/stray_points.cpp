#include "stray_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinetrace::recording {
namespace {

constexpr double kUnseen = 1.25;  // The box excludes the outermost points and unobserved sides.
constexpr double kDeviations = 2.0;
constexpr double kMinError_px = 0.5;  // Lower bound: the residuals of few observations underestimate the error.

}  // namespace

bool StrayPoints::contains(const PointRecord& point) {
  if (point.track_id != track_id_) {
    load_track(point.track_id);
  }
  const double inner_radius_m = kUnseen * radius_m_;
  const double apart_m = (Eigen::Vector3f(point.position_m.data()).cast<double>() - center_m_).norm();
  if (radius_m_ == 0.0 || apart_m <= inner_radius_m) {
    return false;
  }
  // Bounded by the object's size: a less certain depth does not locate the point on the object.
  return apart_m > inner_radius_m + std::min(kDeviations * depth_deviation_m(point), radius_m_);
}

void StrayPoints::load_track(std::uint32_t track_id) {
  track_id_ = track_id;
  radius_m_ = 0.0;
  poses_.seek(last_);
  while (poses_.peek() != nullptr && poses_.peek()->track_id < track_id) {
    poses_.advance();
  }
  first_ = poses_.position();
  for (const PoseRecord* pose = poses_.peek(); pose != nullptr && pose->track_id == track_id; pose = poses_.peek()) {
    if (const auto radius_m = static_cast<double>(pose->box_radius_m); radius_m > radius_m_) {
      radius_m_ = radius_m;
      center_m_ = Eigen::Vector3f(pose->box_center_m.data()).cast<double>();
    }
    poses_.advance();
  }
  last_ = poses_.position();
}

/// Depth error of a stereo observation from the camera's pose when the point left the map: z^2 / (f b) per pixel of
/// disparity.
double StrayPoints::depth_deviation_m(const PointRecord& point) {
  std::uint64_t after = first_;
  for (std::uint64_t end = last_; after < end;) {
    const std::uint64_t middle = after + (end - after) / 2;
    poses_.seek(middle);
    const PoseRecord* pose = poses_.peek();
    if (pose == nullptr) {
      return 0.0;
    }
    (pose->frame <= point.frame ? after : end) = pose->frame <= point.frame ? middle + 1 : middle;
  }
  poses_.seek(std::max(after, first_ + 1) - 1);
  const PoseRecord* pose = poses_.peek();
  if (pose == nullptr) {
    return 0.0;
  }
  const Eigen::Vector3d p_cam = pose->T_body_cam.pose().inverse() * center_m_;
  const double disparity_error_px = std::numbers::sqrt2 * std::max(static_cast<double>(point.error_px), kMinError_px);
  return p_cam.z() * p_cam.z() / (geometry_.fx_px * geometry_.baseline_m) * disparity_error_px;
}

}  // namespace kinetrace::recording
