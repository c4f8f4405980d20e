#include "kinetrace/trajectory/box_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "median.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr std::size_t kMinPoints = 4;
// A point is far off if a gap of this many robust standard deviations, and of this length, lies between it and the
// others on some axis. The distance from the others' middle says less: when most points lie on one face, the rest of a
// long object is far from it.
constexpr double kGapSigmas = 1.0;
constexpr double kMinGap_m = 1.5;
constexpr double kMaxGrowth_m = 0.15;  // Of each side, per update.
constexpr double kMaxShrink_m = 0.003;
constexpr double kMaxTurn_rad = 0.09;
constexpr double kElongated = 2.25;  // Ratio of variances that makes the points' main direction meaningful.
constexpr double kQuarter_rad = 0.5 * std::numbers::pi;

/// Direction of a yaw about y (KITTI rotation_y): 0 = +x, pi/2 = -z.
Eigen::Vector3d direction(double yaw_rad) {
  return {std::cos(yaw_rad), 0.0, -std::sin(yaw_rad)};
}
double yaw_of(const Eigen::Vector3d& horizontal) {
  return std::atan2(-horizontal.z(), horizontal.x());
}
double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2.0 * std::numbers::pi);
}

}  // namespace

BoxEstimator::BoxEstimator(const TrajectoryConfig& config, std::size_t max_points, Arena& arena)
    : config_(config), points_(arena.take<Eigen::Vector3f>(max_points)), scratch_(arena.take<float>(max_points)) {}

void BoxEstimator::reset() noexcept {
  known_ = false;
  heading_known_ = false;
  box_ = Box3{};
}

/// Copies the points that are finite and near the others; returns how many.
std::size_t BoxEstimator::gather(std::span<const BodyPoint> points) noexcept {
  count_ = 0;
  if (points.empty() || points_.empty()) {
    return 0;
  }
  const std::size_t stride = (points.size() + points_.size() - 1) / points_.size();
  for (std::size_t i = 0; i < points.size() && count_ < points_.size(); i += stride) {
    if (points[i].position_m.allFinite()) {
      points_[count_++] = points[i].position_m;
    }
  }
  for (int axis = 0; axis < 3 && count_ > 0; ++axis) {
    const std::pair<float, float> inside = main_cluster(axis);
    const auto end = points_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto kept = std::remove_if(points_.begin(), end, [axis, inside](const Eigen::Vector3f& p) {
      return p[axis] < inside.first || p[axis] > inside.second;
    });
    count_ = static_cast<std::size_t>(kept - points_.begin());
  }
  return count_;
}

/// First and last coordinate that are reached from the median without crossing a gap.
std::pair<float, float> BoxEstimator::main_cluster(int axis) noexcept {
  const auto sorted = scratch_.first(count_);
  std::transform(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_), sorted.begin(),
                 [axis](const Eigen::Vector3f& p) { return p[axis]; });
  const float middle = median(sorted);
  std::transform(sorted.begin(), sorted.end(), sorted.begin(), [middle](float c) { return std::abs(c - middle); });
  const double sigma_m = kSigmaOverMad * double{median(sorted)};
  const auto gap_m = static_cast<float>(std::max(kMinGap_m, kGapSigmas * sigma_m));
  std::transform(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_), sorted.begin(),
                 [axis](const Eigen::Vector3f& p) { return p[axis]; });
  std::sort(sorted.begin(), sorted.end());
  std::size_t low = count_ / 2;
  std::size_t high = low;
  while (low > 0 && sorted[low] - sorted[low - 1] <= gap_m) {
    --low;
  }
  while (high + 1 < count_ && sorted[high + 1] - sorted[high] <= gap_m) {
    ++high;
  }
  return {sorted[low], sorted[high]};
}

BoxEstimator::Extent BoxEstimator::measure(const Eigen::Vector3f& axis) noexcept {
  const auto coordinates = scratch_.first(count_);
  std::transform(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_), coordinates.begin(),
                 [&axis](const Eigen::Vector3f& p) { return p.dot(axis); });
  const auto cut = static_cast<std::size_t>(config_.box_percentile * static_cast<double>(count_ - 1));
  return {double{ranked(coordinates, cut)}, double{ranked(coordinates, count_ - 1 - cut)}};
}

/// Yaw of the points' main horizontal direction, NaN if they have none.
double BoxEstimator::main_direction_rad() const noexcept {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < count_; ++i) {
    mean += Eigen::Vector2d(double{points_[i].x()}, double{points_[i].z()}) / static_cast<double>(count_);
  }
  double xx = 0.0;
  double xz = 0.0;
  double zz = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double x = double{points_[i].x()} - mean.x();
    const double z = double{points_[i].z()} - mean.y();
    xx += x * x;
    xz += x * z;
    zz += z * z;
  }
  const double middle = 0.5 * (xx + zz);
  const double radius = std::hypot(0.5 * (xx - zz), xz);
  if (middle + radius < kElongated * (middle - radius)) {
    return std::nan("");
  }
  const double angle_rad = 0.5 * std::atan2(2.0 * xz, xx - zz);  // From x towards z.
  return -angle_rad;
}

/// Turns the box about its centre: by quarters at once, which keeps its walls, and the rest at a bounded rate.
void BoxEstimator::turn_towards(double yaw_rad) noexcept {
  const double turn_rad = wrapped(yaw_rad - box_.yaw_rad);
  const double quarters = std::round(turn_rad / kQuarter_rad);
  if (static_cast<int>(quarters) % 2 != 0) {
    std::swap(box_.size_m.x(), box_.size_m.z());
  }
  const double rest_rad = std::clamp(turn_rad - quarters * kQuarter_rad, -kMaxTurn_rad, kMaxTurn_rad);
  box_.yaw_rad = wrapped(box_.yaw_rad + quarters * kQuarter_rad + rest_rad);
}

void BoxEstimator::update(std::span<const BodyPoint> points, double yaw_rad) noexcept {
  if (gather(points) < kMinPoints) {
    return;
  }
  double target_rad = yaw_rad;
  if (std::isfinite(yaw_rad)) {
    heading_known_ = true;
  } else if (!heading_known_) {
    target_rad = main_direction_rad();
    if (known_ && std::isfinite(target_rad)) {
      // The main direction has no front: the nearer end of it.
      target_rad = box_.yaw_rad + std::remainder(target_rad - box_.yaw_rad, std::numbers::pi);
    }
  }
  if (std::isfinite(target_rad)) {
    if (known_) {
      turn_towards(target_rad);
    } else {
      box_.yaw_rad = wrapped(target_rad);
    }
  }

  const Eigen::Vector3d axes[3] = {direction(box_.yaw_rad), Eigen::Vector3d::UnitY(),
                                   direction(box_.yaw_rad - kQuarter_rad)};
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Extent seen = measure(axes[i].cast<float>());
    Extent now = seen;
    if (known_) {
      const double middle_m = box_.center_m.dot(axes[i]);
      const double half_m = 0.5 * box_.size_m[i];
      now.low_m = middle_m - half_m + std::clamp(seen.low_m - (middle_m - half_m), -kMaxGrowth_m, kMaxShrink_m);
      now.high_m = middle_m + half_m + std::clamp(seen.high_m - (middle_m + half_m), -kMaxShrink_m, kMaxGrowth_m);
    }
    center_m += 0.5 * (now.low_m + now.high_m) * axes[i];
    box_.size_m[i] = std::max(now.high_m - now.low_m, config_.min_box_size_m);
  }
  box_.center_m = center_m;
  known_ = true;
}

Box3 BoxEstimator::box_in_world(const Se3& T_world_obj) const noexcept {
  return {T_world_obj * box_.center_m, box_.size_m, yaw_of(T_world_obj.rotation * direction(box_.yaw_rad))};
}

}  // namespace kinetrace::trajectory
