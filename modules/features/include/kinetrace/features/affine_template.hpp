// Where a patch of one image lies in others, to a small part of a pixel, whatever its brightness and slant there. For
// work after the recording: the tracking of a live camera has faster kernels.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

/// Where a patch lies in an image, and how it is stretched there: pixel = position + shape * offset in the patch.
struct AffinePlace {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
};

/// How far a patch may be from where it is expected, and how alike it has to be (correlation, at most 1).
struct AffineGate {
  double reach_px = 2.0;
  double correlation = 0.9;
};

/// Lucas and Kanade, inverse compositional (Baker and Matthews, IJCV 2004), over an affine map, gain and offset. All
/// observations of a point are aligned with one template, so that what is wrong in it, and what the surface around the
/// point does, is the same in all of them and makes another point at most; followed from frame to frame it would add
/// up. 10 KiB, no heap.
class AffineTemplate {
 public:
  static constexpr int kRadius_px = 7;

  /// Pixels count by a normal distribution about the middle: there is where the surface is nearest to its tangent
  /// plane. A narrow one (3 px) errs less beside edges of depth, a wide one (4 px) scatters less. Empty at the border
  /// and where nothing is to be seen.
  [[nodiscard]] static std::optional<AffineTemplate> make(const GrayView& image, const Eigen::Vector2d& at,
                                                          double sigma_px);

  /// From `guess`. Empty if the patch leaves the image, does not pass the gate, is stretched to more than twice or less
  /// than half its size, or does not converge.
  [[nodiscard]] std::optional<AffinePlace> align(const GrayView& image, const AffinePlace& guess,
                                                 const AffineGate& gate) const;

 private:
  static constexpr int kSide = 2 * kRadius_px + 1;
  static constexpr int kPixels = kSide * kSide;
  static constexpr int kParameters = 8;  ///< x, y, four of the shape, gain, offset.
  using Patch = Eigen::Matrix<float, kPixels, 1>;

  /// Of a pixel of the patch from its middle.
  [[nodiscard]] static Eigen::Vector2d offset_px(int pixel);
  /// Takes the weighted mean out and divides by the weighted spread, which it returns.
  float normalise(Patch& patch) const;
  [[nodiscard]] static bool sample(const GrayView& image, const AffinePlace& place, Patch& out);

  Patch weights_;
  Patch value_;
  Eigen::Matrix<float, kParameters, kPixels> weighted_;  ///< Derivatives, transposed and weighted.
  Eigen::LLT<Eigen::Matrix<float, kParameters, kParameters>> normal_;
};

}  // namespace kinetrace::features
