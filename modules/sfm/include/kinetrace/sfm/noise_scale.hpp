// How far measurements really scatter: learnt from the residuals of each frame.
#pragma once

#include <span>

namespace kinetrace::sfm {

/// Standard deviation of an image coordinate, learnt as a running robust scale (Hampel 1974: the median of squared
/// residuals over that of a unit Gaussian). Gates and weights that are wider than the measurements deserve let in
/// mismatches, which always pull a trajectory in the same direction.
class NoiseScale {
 public:
  /// `most_px` is where it starts and what it never exceeds; it never falls below `least_px`.
  NoiseScale(double least_px, double most_px) : least_px_(least_px), most_px_(most_px), sigma_px_(most_px) {}

  [[nodiscard]] double sigma_px() const noexcept { return sigma_px_; }
  [[nodiscard]] double most_px() const noexcept { return most_px_; }

  /// Takes in one frame: `squared_px2` holds each stereo observation's squared residual (three coordinates: u_left, v,
  /// u_right) after a pose was fitted to all of them; reordered. Fewer than four say nothing.
  void learn(std::span<float> squared_px2);
  /// Nothing is known any more.
  void restart() noexcept {
    sigma_px_ = most_px_;
    frames_ = 0;
  }
  /// Frames taken in since the start: after few of them, `sigma_px` still tells of where it started.
  [[nodiscard]] int frames() const noexcept { return frames_; }

 private:
  double least_px_;
  double most_px_;
  double sigma_px_;
  int frames_ = 0;
};

}  // namespace kinetrace::sfm
