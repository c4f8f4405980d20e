#include "stereo_observation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kMaxObservedFeatures = 256;  // Medians over more than this are no better.
// Spread of the disparities of one object: absolute, and relative.
constexpr double kMinDisparityTolerance_px = 0.75;
constexpr double kRelativeDisparityTolerance = 0.1;
constexpr std::size_t kDisparity = 2;  // Of an observation's (u, v, disparity).

/// Component-wise medians.
template <int kQuantities>
class Medians {
 public:
  using Values = Eigen::Matrix<double, kQuantities, 1>;

  [[nodiscard]] bool full() const noexcept { return count_ == kMaxObservedFeatures; }
  [[nodiscard]] int count() const noexcept { return static_cast<int>(count_); }
  void add(const Values& values) noexcept {
    for (std::size_t i = 0; i < kQuantities; ++i) {
      values_[i][count_] = values[static_cast<Eigen::Index>(i)];
    }
    ++count_;
  }
  /// Zero without values. Reorders them.
  [[nodiscard]] Values take() noexcept {
    Values medians = Values::Zero();
    for (std::size_t i = 0; i < kQuantities && count_ > 0; ++i) {
      medians[static_cast<Eigen::Index>(i)] = median(std::span(values_[i]).first(count_));
    }
    return medians;
  }

  /// How many values of one quantity lie within `tolerance` of `value`.
  [[nodiscard]] int count_near(std::size_t quantity, double value, double tolerance) const noexcept {
    const std::span<const double> values = std::span(values_[quantity]).first(count_);
    return static_cast<int>(std::count_if(values.begin(), values.end(),
                                          [&](double other) { return std::abs(other - value) <= tolerance; }));
  }

 private:
  std::array<std::array<double, kMaxObservedFeatures>, kQuantities> values_;
  std::size_t count_ = 0;
};

}  // namespace

StereoObservation observe_stereo(const FeatureFrame& frame, std::uint8_t label, double min_disparity_px) {
  Medians<3> position;
  Medians<4> motion;
  for (const Feature& feature : frame.features) {
    if (feature.body == label && feature.has_right() && double{feature.disparity_px()} >= min_disparity_px &&
        !position.full()) {
      const Eigen::Vector2d now_px = feature.left_px.cast<double>();
      position.add({now_px.x(), double{feature.v_px}, double{feature.disparity_px()}});
      if (feature.age_frames > 0) {
        const Eigen::Vector2d moved_px = now_px - feature.previous_left_px.cast<double>();
        motion.add({now_px.x(), now_px.y(), moved_px.x(), moved_px.y()});
      }
    }
  }
  StereoObservation observation;
  observation.features = position.count();
  observation.uvd_px = position.take();
  observation.agreeing = position.count_near(
      kDisparity, observation.uvd_px[kDisparity],
      std::max(kMinDisparityTolerance_px, kRelativeDisparityTolerance * observation.uvd_px[kDisparity]));
  observation.motion.features = motion.count();
  const Eigen::Vector4d now_and_moved_px = motion.take();
  observation.motion.now_px = now_and_moved_px.head<2>();
  observation.motion.before_px = now_and_moved_px.head<2>() - now_and_moved_px.tail<2>();
  return observation;
}

Eigen::Vector3d position_in_camera(const StereoGeometry& geometry, const StereoObservation& observation) {
  return geometry.triangulate(observation.uvd_px.x(), observation.uvd_px.y(), observation.uvd_px.z());
}

double mean_column(LabelView labels, const PixelBox& box, std::uint8_t label) {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  for (int y = std::max(box.y0, 0); y < std::min(box.y1, labels.height); ++y) {
    const std::uint8_t* const row = labels.row(y);
    for (int x = std::max(box.x0, 0); x < std::min(box.x1, labels.width); ++x) {
      const std::int64_t own = row[x] == label ? 1 : 0;
      sum += own * x;
      count += own;
    }
  }
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : box.center_x();
}

}  // namespace kinetrace::pipeline
