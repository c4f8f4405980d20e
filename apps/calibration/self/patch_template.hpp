// Where a patch of one image lies in others, to a small part of a pixel, whatever its brightness and slant there.
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace kinetrace::self_calibration {

/// Where a patch lies in an image, and how it is stretched there: pixel = position + shape * offset in the patch.
struct PatchPlace {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
};

/// Lucas and Kanade, inverse compositional (Baker and Matthews, IJCV 2004), over an affine map, gain and offset. All
/// observations of a point are aligned with one template, so that what is wrong in it, and what the surface around the
/// point does, is the same in all of them and makes another point at most; followed from frame to frame it would add
/// up.
class PatchTemplate {
 public:
  static constexpr int kRadius_px = 7;

  /// Of a 32-bit float image; empty at the border and where nothing is to be seen.
  [[nodiscard]] static std::optional<PatchTemplate> make(const cv::Mat& image, const Eigen::Vector2d& at);

  /// From `guess`. Empty if the patch leaves the image, moves more than `reach_px`, is stretched to more than twice or
  /// less than half its size, does not converge, or correlates by less than `correlation`.
  [[nodiscard]] std::optional<PatchPlace> align(const cv::Mat& image, const PatchPlace& guess, double reach_px,
                                                double correlation) const;

 private:
  static constexpr int kSide = 2 * kRadius_px + 1;
  static constexpr int kPixels = kSide * kSide;
  static constexpr int kParameters = 8;  ///< x, y, four of the shape, gain, offset.
  using Patch = Eigen::Matrix<float, kPixels, 1>;

  static const Patch& weights();
  static float normalise(Patch& patch);
  [[nodiscard]] static bool sample(const cv::Mat& image, const PatchPlace& place, Patch& out);

  Patch value_;
  Eigen::Matrix<float, kParameters, kPixels> weighted_;  ///< Derivatives, transposed and weighted.
  Eigen::LLT<Eigen::Matrix<float, kParameters, kParameters>> normal_;
};

}  // namespace kinetrace::self_calibration
