#include "kinetrace/sfm/noise_scale.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::sfm {
namespace {

constexpr double kChiSquare3Median = 2.366;  // Of three squared unit Gaussians.
constexpr double kPoseFreedom = 6.0;         // Degrees of freedom of the fitted pose.
constexpr std::size_t kMinResiduals = 4;
// Gain of the running variance for a frame of many residuals; half of it for one of kHalfTrusted.
constexpr double kRate = 0.3;
constexpr double kHalfTrusted = 20.0;

}  // namespace

void NoiseScale::learn(std::span<float> squared_px2) {
  if (squared_px2.size() < kMinResiduals) {
    return;
  }
  const auto count = static_cast<double>(squared_px2.size());
  const double freedom = 3.0 * count;
  const double variance_px2 = double{median(squared_px2)} / kChiSquare3Median * freedom / (freedom - kPoseFreedom);
  const double rate = kRate * count / (count + kHalfTrusted);
  const double running_px2 = sigma_px_ * sigma_px_ + rate * (variance_px2 - sigma_px_ * sigma_px_);
  sigma_px_ = std::clamp(std::sqrt(running_px2), least_px_, most_px_);
}

}  // namespace kinetrace::sfm
