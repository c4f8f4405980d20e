#include "kinetrace/segmentation/ground_plane.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "dense_kernels.hpp"
#include "kinetrace/segmentation/cell_disparity.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kSamples = 100;
/// Every third cell in both directions suffices.
constexpr int kCellStep = 3;
/// Tolerance of points on the plane, pixels of the matching images: noise, and slight unevenness.
constexpr float kTolerancePx = 0.5F;
/// Least cosine between the plane's normal and the image's downward direction: the camera looks down by 75 degrees at
/// most.
constexpr float kMinDownward = 0.25F;
/// Least fraction of points below the plane's horizon that lie on it, net of those beyond it.
constexpr float kMinShare = 0.1F;
/// Heights of objects: least one, above the ground's unevenness, greatest one, and the bound of may_hold_object().
constexpr float kLowestM = 0.2F;
constexpr float kHighestM = 3.F;
constexpr float kOutOfReachM = 4.5F;
constexpr float kUnevennessM = 0.06F;
/// Densities per metre: of the heights of objects, and of outliers, below the ground or far above.
constexpr float kObjectDensity = 1.F / (kHighestM - kLowestM);
constexpr float kElsewhere = 0.02F;

std::uint32_t next_random(std::uint32_t& state) noexcept {
  state ^= state << 13U;
  state ^= state >> 17U;
  state ^= state << 5U;
  return state;
}

/// Standard deviations beyond which a tail probability is below the resolution of a float, beside kElsewhere.
constexpr float kCertain = 6.F;

float normal_cdf(float x) noexcept {
  return x > kCertain ? 1.F : x < -kCertain ? 0.F : 0.5F * std::erfc(-0.70710678F * x);
}

float normal_density(float x) noexcept {
  return std::abs(x) > kCertain ? 0.F : std::exp(-0.5F * x * x) / 2.5066F;
}

// Excludes walls, and objects that fill the image.
bool looks_down(const Eigen::Vector3f& normal) noexcept {
  return normal.y() > kMinDownward * normal.norm();
}

}  // namespace

GroundPlane::GroundPlane(const StereoGeometry& geometry, Arena& arena) : geometry_(geometry) {
  const std::size_t most = static_cast<std::size_t>(geometry.width_px / (kCellPx * kCellStep) + 1) *
                           static_cast<std::size_t>(geometry.height_px / (kCellPx * kCellStep) + 1);
  u_px_ = FixedVector<float>(arena, most);
  v_px_ = FixedVector<float>(arena, most);
  disparity_px_ = FixedVector<float>(arena, most);
}

int GroundPlane::score(const Eigen::Vector3f& plane, float tolerance_px) const {
  return dense_kernels().plane_score(
      {u_px_.begin(), v_px_.begin(), disparity_px_.begin(), static_cast<int>(u_px_.size())}, plane.data(),
      tolerance_px);
}

int GroundPlane::points_below_horizon() const {
  int points = 0;
  for (std::size_t i = 0; i < u_px_.size(); ++i) {
    points += disparity_px(plane_, u_px_[i], v_px_[i]) > 0.F ? 1 : 0;
  }
  return points;
}

// Least squares over the inliers.
void GroundPlane::refine(float tolerance_px) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < u_px_.size(); ++i) {
    if (std::abs(disparity_px_[i] - disparity_px(plane_, u_px_[i], v_px_[i])) <= tolerance_px) {
      const Eigen::Vector3d row(u_px_[i], v_px_[i], 1.0);
      a += row * row.transpose();
      b += static_cast<double>(disparity_px_[i]) * row;
    }
  }
  const Eigen::Vector3d better = a.ldlt().solve(b);
  if (better.allFinite()) {
    plane_ = better.cast<float>();
  }
}

void GroundPlane::fit(ImageView<const float> cell_disparity_px, std::uint32_t seed) {
  u_px_.clear();
  v_px_.clear();
  disparity_px_.clear();
  for (int cy = 0; cy < cell_disparity_px.height; cy += kCellStep) {
    for (int cx = 0; cx < cell_disparity_px.width; cx += kCellStep) {
      const float d = cell_disparity_px.row(cy)[cx];
      if (d > 0.F) {
        (void)u_px_.push_back(cell_center(cx));  // as many places as cells looked at
        (void)v_px_.push_back(cell_center(cy));
        (void)disparity_px_.push_back(d);
      }
    }
  }
  // The ground lies below the image's middle, wherever else it may be. Points are in the order of rows.
  const auto count = static_cast<std::uint32_t>(u_px_.size());
  const auto lower = static_cast<std::uint32_t>(
      std::upper_bound(v_px_.begin(), v_px_.end(), static_cast<float>(geometry_.cy_px)) - v_px_.begin());
  if (count - lower < 12) {
    return;  // too few: the previous plane stays
  }
  const float tolerance_px = kTolerancePx * static_cast<float>(matching_step(geometry_.width_px));
  std::uint32_t state = seed | 1U;
  int best = known_ ? score(plane_, tolerance_px) : 0;
  for (int k = 0; k < kSamples; ++k) {
    Eigen::Matrix3f m;
    Eigen::Vector3f d;
    for (int row = 0; row < 3; ++row) {
      const std::size_t i = lower + next_random(state) % (count - lower);
      m.row(row) << u_px_[i], v_px_[i], 1.F;
      d[row] = disparity_px_[i];
    }
    if (std::abs(m.determinant()) < 1000.F) {  // twice the triangle's area in square pixels
      continue;
    }
    const Eigen::Vector3f plane = m.inverse() * d;
    const int s = looks_down(scaled_normal(plane)) ? score(plane, tolerance_px) : 0;
    if (s > best) {
      best = s;
      plane_ = plane;
    }
  }
  known_ = best > 0 && static_cast<float>(best) >= kMinShare * static_cast<float>(points_below_horizon());
  if (!known_) {
    return;
  }
  refine(tolerance_px);
  refine(0.5F * tolerance_px);
  const Eigen::Vector3f n = scaled_normal(plane_);
  known_ = looks_down(n);
  camera_height_m_ = static_cast<float>(geometry_.fx_px * geometry_.baseline_m) / n.norm();
}

// With n X = h, the plane's disparity at X is f b (n X) / (h z): its coefficients are f b n / h, up to the intrinsics.
Eigen::Vector3f GroundPlane::scaled_normal(const Eigen::Vector3f& plane) const noexcept {
  return {plane.x() * static_cast<float>(geometry_.fx_px), plane.y() * static_cast<float>(geometry_.fy_px),
          disparity_px(plane, static_cast<float>(geometry_.cx_px), static_cast<float>(geometry_.cy_px))};
}

Eigen::Vector3f GroundPlane::normal() const noexcept {
  return known_ ? Eigen::Vector3f(scaled_normal(plane_).normalized()) : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

bool GroundPlane::may_hold_object(float u, float v, float disparity, float sigma_px) const noexcept {
  const float height = camera_height_m_ * (1.F - disparity_px(plane_, u, v) / disparity);
  const bool out_of_reach = known_ && height - 3.F * camera_height_m_ * sigma_px / disparity > kOutOfReachM;
  return !out_of_reach && object_nats(u, v, disparity, sigma_px) > kGroundNats;
}

float GroundPlane::object_nats(float u, float v, float disparity, float sigma_px) const noexcept {
  if (!known_) {
    return 0.F;
  }
  const float height_m = camera_height_m_ * (1.F - disparity_px(plane_, u, v) / disparity);
  const float noise_m = camera_height_m_ * sigma_px / disparity;
  const float sigma_m = std::sqrt(noise_m * noise_m + kUnevennessM * kUnevennessM);
  const float on_ground = normal_density(height_m / sigma_m) / sigma_m;
  const float on_object =
      (normal_cdf((height_m - kLowestM) / sigma_m) - normal_cdf((height_m - kHighestM) / sigma_m)) * kObjectDensity;
  return std::log((on_object + kElsewhere) / (on_ground + kElsewhere));
}

}  // namespace kinetrace::segmentation
