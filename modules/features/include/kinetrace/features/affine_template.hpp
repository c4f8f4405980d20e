// Locates a patch of one image in others, to a small part of a pixel, invariant to gain, offset and affine warp. For
// work after the recording: live tracking has faster kernels.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

/// Place of a patch in an image: pixel = position + shape * offset in the patch.
struct AffinePlace {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
};

/// Largest distance of a patch from its initial position, and least correlation (at most 1).
struct AffineGate {
  double reach_px = 2.0;
  double correlation = 0.9;
};

/// Inverse-compositional Lucas-Kanade (Baker and Matthews, IJCV 2004), over an affine map, gain and offset. All
/// observations of a point are aligned with one template: errors of the template and of the surface around the point
/// are common to all, and at most move the point; tracked from frame to frame they would accumulate. 10 KiB, no heap.
class AffineTemplate {
 public:
  static constexpr int kRadius_px = 7;

  /// Pixels are weighted by a Gaussian about the centre, where the surface is nearest to its tangent plane. A narrow
  /// one (3 px) has less bias beside depth edges, a wide one (4 px) less noise. Empty at the image border and without
  /// texture.
  [[nodiscard]] static std::optional<AffineTemplate> make(const GrayView& image, const Eigen::Vector2d& at,
                                                          double sigma_px);

  /// Alignment from `guess`. Empty if the patch leaves the image, does not pass the gate, is scaled by more than two or
  /// less than one half, or does not converge.
  [[nodiscard]] std::optional<AffinePlace> align(const GrayView& image, const AffinePlace& guess,
                                                 const AffineGate& gate) const;

 private:
  static constexpr int kSide = 2 * kRadius_px + 1;
  static constexpr int kPixels = kSide * kSide;
  static constexpr int kParameters = 8;  ///< x, y, four of the shape, gain, offset.
  using Patch = Eigen::Matrix<float, kPixels, 1>;

  /// Offset of a pixel of the patch from its centre.
  [[nodiscard]] static Eigen::Vector2d offset_px(int pixel);
  /// Subtracts the weighted mean and divides by the weighted standard deviation, which is returned.
  float normalise(Patch& patch) const;
  [[nodiscard]] static bool sample(const GrayView& image, const AffinePlace& place, Patch& out);

  Patch weights_;
  Patch value_;
  Eigen::Matrix<float, kParameters, kPixels> weighted_;  ///< Derivatives, transposed and weighted.
  Eigen::LLT<Eigen::Matrix<float, kParameters, kParameters>> normal_;
};

}  // namespace kinetrace::features
