// Standard deviation of the measurements, estimated from the residuals of each frame.
#pragma once

#include <span>

namespace kinetrace::sfm {

/// Standard deviation of an image coordinate, as a running robust scale (Hampel 1974: the median of squared residuals
/// over that of a unit Gaussian). Gates and weights wider than the noise admit mismatches, which always pull a
/// trajectory in the same direction.
class NoiseScale {
 public:
  /// `most_px` is the initial value and upper bound, `least_px` the lower bound.
  NoiseScale(double least_px, double most_px) : least_px_(least_px), most_px_(most_px), sigma_px_(most_px) {}

  [[nodiscard]] double sigma_px() const noexcept { return sigma_px_; }
  [[nodiscard]] double most_px() const noexcept { return most_px_; }

  /// Adds one frame: `squared_px2` holds each stereo observation's squared residual (three coordinates: u_left, v,
  /// u_right) after a pose was fitted to all of them; reordered. Fewer than four are ignored.
  void learn(std::span<float> squared_px2);
  /// Returns to the initial value.
  void restart() noexcept { sigma_px_ = most_px_; }

 private:
  double least_px_;
  double most_px_;
  double sigma_px_;
};

}  // namespace kinetrace::sfm
