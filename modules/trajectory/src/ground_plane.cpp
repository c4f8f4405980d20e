#include "kinetrace/trajectory/ground_plane.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetrace::trajectory {
namespace {

constexpr std::size_t kMinPoints = 12;
constexpr std::uint32_t kFirstSamples = 100;
constexpr std::uint32_t kSamples = 10;          // Per frame; the current plane stays a candidate.
constexpr float kMinCosine = 0.34F;             // 70 degrees from the camera's y axis.
constexpr float kMinHeight_m = 0.3F;            // Of the camera above the ground.
constexpr float kRange_m = 40.F;                // Beyond, roads bend and stereo is coarse.
constexpr float kRoughnessSigma_m = 0.05F;      // Kerbs and bumps, standard deviation.
constexpr float kRelativeHeightSigma = 0.006F;  // Error of a point's height, relative to its distance.
constexpr float kInlierSigmas = 2.5F;
constexpr float kBelowPenalty = 1.5F;  // A point below weighs more than an inlier: nothing is visible below the ground.
constexpr double kMinInlierFraction = 0.08;  // Of the points, on the ground.
constexpr int kMaxAveragedFrames = 10;       // Frames over which the slope is averaged: roads bend slowly.
constexpr double kSamePlaneSigmas = 4.0;     // Of the slope; a larger change means another plane.
constexpr double kMinScatter = 0.05;         // Minimum of squared residuals over tolerances; less is chance.
constexpr double kMinSlope_rad = 0.006;

/// A hash of a number (Steele, Lea and Flood 2014).
std::uint32_t hash(std::uint32_t value) {
  std::uint64_t z = value + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return static_cast<std::uint32_t>(z >> 32U);
}

}  // namespace

GroundEstimator::GroundEstimator(std::size_t max_points, Arena& arena)
    : points_(arena.take<Eigen::Vector3f>(max_points)) {}

void GroundEstimator::gather(std::span<const BodyPoint> points, const Se3& T_world_cam) noexcept {
  count_ = 0;
  camera_down_ = T_world_cam.rotation.col(1).cast<float>();
  const Eigen::Vector3f camera_m = T_world_cam.translation.cast<float>();
  for (const BodyPoint& point : points) {
    const Eigen::Vector3f p = point.position_m - camera_m;
    if (count_ < points_.size() && p.squaredNorm() < kRange_m * kRange_m) {
      points_[count_++] = p;
    }
  }
}

float GroundEstimator::tolerance_m(const Eigen::Vector3f& point_m) const noexcept {
  return kInlierSigmas * std::hypot(kRoughnessSigma_m, kRelativeHeightSigma * point_m.norm());
}

/// Inliers, minus a penalty for points below the plane.
float GroundEstimator::score(const Plane& plane) const noexcept {
  float sum = 0.F;
  for (std::size_t i = 0; i < count_; ++i) {
    const float below = (plane.down.dot(points_[i]) - plane.height_m) / tolerance_m(points_[i]);
    sum += below > 1.F ? -kBelowPenalty : std::max(1.F - below * below, 0.F);
  }
  return sum;
}

/// The plane through three of the points; false if that is no ground.
bool GroundEstimator::plane_through(std::uint32_t seed, Plane& plane) const noexcept {
  const auto at = [&](std::uint32_t k) -> const Eigen::Vector3f& { return points_[hash(3U * seed + k) % count_]; };
  const Eigen::Vector3f normal = (at(1) - at(0)).cross(at(2) - at(0));
  const float length = normal.norm();
  if (length < 0.5F) {
    return false;  // Less than a square metre between them.
  }
  plane.down = normal / (normal.dot(camera_down_) > 0.F ? length : -length);
  plane.height_m = plane.down.dot(at(0));
  return plane.down.dot(camera_down_) > kMinCosine && plane.height_m > kMinHeight_m;
}

/// Least squares over the points on `plane`, the slope averaged with that of the frames before.
void GroundEstimator::refine(const Plane& plane, const Se3& T_world_cam) noexcept {
  Plane fitted = plane;
  double inliers = 0.0;
  double scatter = 0.0;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (int round = 0; round < 2; ++round) {
    const Eigen::Vector3f u = fitted.down.unitOrthogonal();
    const Eigen::Vector3f v = fitted.down.cross(u);
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    information.setZero();
    inliers = 0.0;
    scatter = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      const float tolerance = tolerance_m(points_[i]);
      const float off = fitted.down.dot(points_[i]) - fitted.height_m;
      if (std::abs(off) < tolerance) {
        const Eigen::Vector3d row(double{u.dot(points_[i])}, double{v.dot(points_[i])}, 1.0);
        const double weight = 1.0 / double{tolerance * tolerance};
        information += weight * row * row.transpose();
        gradient += weight * double{off} * row;
        inliers += 1.0;
        scatter += weight * double{off * off};
      }
    }
    if (inliers < static_cast<double>(kMinPoints)) {
      return;
    }
    const Eigen::Vector3f step = information.ldlt().solve(gradient).cast<float>();
    const Eigen::Vector3f normal = fitted.down - step.x() * u - step.y() * v;
    fitted.height_m = (fitted.height_m + step.z()) / normal.norm();
    fitted.down = normal.normalized();
  }
  const Eigen::Matrix3d covariance = std::max(scatter / inliers, kMinScatter) * information.inverse();
  const double slope_sigma_rad = std::sqrt(std::max(covariance(0, 0), covariance(1, 1))) + kMinSlope_rad;
  const Eigen::Vector3d down = fitted.down.cast<double>();
  const bool is_same = ground_.known && (down - ground_.down).norm() < kSamePlaneSigmas * slope_sigma_rad;
  averaged_ = is_same ? std::min(averaged_ + 1, kMaxAveragedFrames) : 1;
  ground_.down = (ground_.down + (down - ground_.down) / averaged_).normalized();
  ground_.height_m = fitted.height_m + ground_.down.dot(T_world_cam.translation);
  ground_.known = true;
  ground_.sigma_m = std::sqrt(covariance(2, 2)) + double{kRoughnessSigma_m};
  ground_.slope_sigma_rad = slope_sigma_rad;
}

void GroundEstimator::update(std::span<const BodyPoint> points, const Se3& T_world_cam) noexcept {
  gather(points, T_world_cam);
  ++frames_;
  if (count_ < kMinPoints) {
    return;
  }
  Plane best{ground_.down.cast<float>(),
             static_cast<float>(ground_.height_m - ground_.down.dot(T_world_cam.translation))};
  float best_score = ground_.known ? score(best) : static_cast<float>(kMinInlierFraction * static_cast<double>(count_));
  bool found = ground_.known && best_score > 0.F;
  const std::uint32_t samples = ground_.known ? kSamples : kFirstSamples;
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    Plane plane;
    if (plane_through(frames_ * kFirstSamples + sample, plane)) {
      if (const float candidate_score = score(plane); candidate_score > best_score) {
        best_score = candidate_score;
        best = plane;
        found = true;
      }
    }
  }
  if (found && best_score > static_cast<float>(kMinInlierFraction * static_cast<double>(count_))) {
    refine(best, T_world_cam);
  }
}

}  // namespace kinetrace::trajectory
