#include "kinetrace/segmentation/ground_plane.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "kinetrace/segmentation/cell_disparity.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kSamples = 60;
/// Every third cell to both sides is plenty.
constexpr int kCellStep = 3;
/// Pixels of the matching images by which a point on the plane may be off it: noise, and ground that is not quite flat.
constexpr float kTolerancePx = 0.5F;
/// A point beyond the plane speaks against it as much as so many on it for it.
constexpr float kBeyondWeight = 1.F;
/// Part of the points that the plane must hold, net of those beyond it.
/// Least cosine between the plane's normal and the image's downward direction: the camera looks down by 75 degrees at
/// most.
constexpr float kMinDownward = 0.25F;
constexpr float kMinShare = 0.1F;
/// How high objects reach, and where the ground's own unevenness ends.
constexpr float kLowestM = 0.2F;
constexpr float kHighestM = 3.F;
constexpr float kOutOfReachM = 4.5F;
/// Log-likelihood ratio below which something is ground.
constexpr float kGroundNats = -2.F;
constexpr float kUnevennessM = 0.06F;

std::uint32_t next_random(std::uint32_t& state) noexcept {
  state ^= state << 13U;
  state ^= state >> 17U;
  state ^= state << 5U;
  return state;
}

float normal_cdf(float x) noexcept {
  return 0.5F * std::erfc(-0.70710678F * x);
}

// A wall, or an object that fills the image, is no ground.
bool looks_down(const Eigen::Vector3f& normal) noexcept {
  return normal.y() > kMinDownward * normal.norm();
}

}  // namespace

GroundPlane::GroundPlane(const StereoGeometry& geometry, Arena& arena)
    : geometry_(geometry),
      points_(arena, static_cast<std::size_t>(geometry.width_px / (kCellPx * kCellStep) + 1) *
                         static_cast<std::size_t>(geometry.height_px / (kCellPx * kCellStep) + 1)) {}

float GroundPlane::score(const Eigen::Vector3f& plane, float tolerance_px) const {
  float total = 0.F;
  for (const Eigen::Vector3f& p : points_) {
    const float off = p.z() - disparity_px(plane, p.x(), p.y());
    total += std::abs(off) <= tolerance_px ? 1.F : 0.F;
    total -= off < -3.F * tolerance_px ? kBeyondWeight : 0.F;
  }
  return total;
}

// Least squares over the points on it.
void GroundPlane::refine(float tolerance_px) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points_) {
    if (std::abs(p.z() - disparity_px(plane_, p.x(), p.y())) <= tolerance_px) {
      const Eigen::Vector3d row(p.x(), p.y(), 1.0);
      a += row * row.transpose();
      b += static_cast<double>(p.z()) * row;
    }
  }
  const Eigen::Vector3d better = a.ldlt().solve(b);
  if (better.allFinite()) {
    plane_ = better.cast<float>();
  }
}

void GroundPlane::fit(ImageView<const float> cell_disparity_px, std::uint32_t seed) {
  points_.clear();
  for (int cy = 0; cy < cell_disparity_px.height; cy += kCellStep) {
    for (int cx = 0; cx < cell_disparity_px.width; cx += kCellStep) {
      const float d = cell_disparity_px.row(cy)[cx];
      if (d > 0.F) {
        (void)points_.push_back({cell_center(cx), cell_center(cy), d});  // as many places as cells looked at
      }
    }
  }
  const auto count = static_cast<std::uint32_t>(points_.size());
  if (count < 12) {
    return;  // too few to say anything: what was known stays
  }
  const float tolerance_px = kTolerancePx * static_cast<float>(matching_step(geometry_.width_px));
  std::uint32_t state = seed | 1U;
  float best = known_ ? score(plane_, tolerance_px) : 0.F;
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::Vector3f& p = points_[next_random(state) % count];
    const Eigen::Vector3f& q = points_[next_random(state) % count];
    const Eigen::Vector3f& r = points_[next_random(state) % count];
    Eigen::Matrix3f m;
    m << p.x(), p.y(), 1.F, q.x(), q.y(), 1.F, r.x(), r.y(), 1.F;
    if (std::abs(m.determinant()) < 1000.F) {  // twice the triangle's area in square pixels
      continue;
    }
    const Eigen::Vector3f plane = m.inverse() * Eigen::Vector3f(p.z(), q.z(), r.z());
    const float s = looks_down(scaled_normal(plane)) ? score(plane, tolerance_px) : 0.F;
    if (s > best) {
      best = s;
      plane_ = plane;
    }
  }
  known_ = best >= kMinShare * static_cast<float>(count);
  if (!known_) {
    return;
  }
  refine(tolerance_px);
  refine(0.5F * tolerance_px);
  const Eigen::Vector3f n = scaled_normal(plane_);
  known_ = looks_down(n);
  camera_height_m_ = static_cast<float>(geometry_.fx_px * geometry_.baseline_m) / n.norm();
}

// With n X = h, the plane's disparity at X is f b (n X) / (h z): its coefficients are f b n / h, up to the camera's
// own.
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
  const float ground_px = disparity_px(plane_, u, v);
  const float height = camera_height_m_ * (1.F - ground_px / disparity);
  const float sigma = std::hypot(camera_height_m_ * sigma_px / disparity, kUnevennessM);
  const float on_ground = std::exp(-0.5F * height * height / (sigma * sigma)) / (2.5066F * sigma);
  const float on_object =
      (normal_cdf((height - kLowestM) / sigma) - normal_cdf((height - kHighestM) / sigma)) / (kHighestM - kLowestM);
  constexpr float kElsewhere = 0.02F;  // density of what is neither: below the ground, or far above
  return std::log((on_object + kElsewhere) / (on_ground + kElsewhere));
}

}  // namespace kinetrace::segmentation
