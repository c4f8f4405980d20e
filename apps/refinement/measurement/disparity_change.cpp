#include "disparity_change.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

namespace kinetrace::batch {
namespace {

using recording::Observation;

constexpr std::size_t kMinPoints = 30;
constexpr int kRounds = 8;
constexpr double kHuber_px = 0.1;
// With a true calibration, mean disparities of a frame by the run's matching and by one template a point differ by less
// than this (rendered street and drone, KITTI raw 0039).
constexpr double kMatching_px = 0.03;
constexpr double kSure_sigmas = 3.0;

Eigen::Vector3d place(const StereoGeometry& geometry, double u_px, double v_px) {
  return {1.0, (u_px - geometry.cx_px) / geometry.fx_px, (v_px - geometry.cy_px) / geometry.fy_px};
}

struct Sample {
  Eigen::Vector3d place;
  double change_px = 0.0;
};

std::vector<Sample> samples_of(const StereoGeometry& geometry, std::span<const Observation> before,
                               std::span<const Observation> now) {
  std::vector<Sample> samples;
  samples.reserve(before.size());
  for (std::size_t i = 0; i < std::min(before.size(), now.size()); ++i) {
    const double change_px = (double{now[i].u_left_px} - double{now[i].u_right_px}) -
                             (double{before[i].u_left_px} - double{before[i].u_right_px});
    if (std::isfinite(change_px)) {
      samples.push_back({place(geometry, before[i].u_left_px, before[i].v_px), change_px});
    }
  }
  return samples;
}

struct Plane {
  Eigen::Vector3d change_px = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< With unit weights.
};

// Least squares with Huber's weights (1964).
Plane fit(const std::vector<Sample>& samples) {
  Plane plane;
  for (int round = 0; round < kRounds; ++round) {
    Plane next{.information = 1e-6 * Eigen::Matrix3d::Identity()};
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    for (const Sample& sample : samples) {
      const double residual_px = sample.change_px - plane.change_px.dot(sample.place);
      const double weight = std::min(1.0, kHuber_px / std::max(std::abs(residual_px), 1e-9));
      next.information += weight * sample.place * sample.place.transpose();
      weighted += weight * sample.change_px * sample.place;
    }
    next.change_px = next.information.ldlt().solve(weighted);
    plane = next;
  }
  return plane;
}

// Significance at the points' positions: the mean square change against its uncertainty.
bool is_sure(const Plane& plane, const std::vector<Sample>& samples) {
  const Eigen::Matrix3d covariance = kHuber_px * kHuber_px * plane.information.inverse();
  double mean_square = 0.0;
  double variance = kMatching_px * kMatching_px;
  for (const Sample& sample : samples) {
    const double change_px = plane.change_px.dot(sample.place);
    mean_square += change_px * change_px / static_cast<double>(samples.size());
    variance += sample.place.dot(covariance * sample.place) / static_cast<double>(samples.size());
  }
  return mean_square > kSure_sigmas * kSure_sigmas * variance;
}

}  // namespace

DisparityChange DisparityChange::between(const StereoGeometry& geometry, std::span<const Observation> before,
                                         std::span<const Observation> now) {
  const std::vector<Sample> samples = samples_of(geometry, before, now);
  DisparityChange change;
  if (samples.size() < kMinPoints) {
    return change;
  }
  if (const Plane plane = fit(samples); is_sure(plane, samples)) {
    change.change_px_ = plane.change_px;
  }
  return change;
}

double DisparityChange::at(const StereoGeometry& geometry, double u_px, double v_px) const noexcept {
  return change_px_.dot(place(geometry, u_px, v_px));
}

}  // namespace kinetrace::batch
