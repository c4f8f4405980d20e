// Where a patch of one image lies in another, to a small part of a pixel, whatever the brightness of the two.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace kinetrace::self_calibration {

/// Lucas and Kanade, inverse compositional (Baker and Matthews, IJCV 2004), over translation, gain and offset: views
/// differ in sensitivity, and a patch of unequal brightness would move by it. Images are 32-bit floats.
class PatchAligner {
 public:
  static constexpr int kRadius_px = 7;

  /// Position in `target` of the patch around `at` in `source`, started at `guess`. Empty if it leaves the image, moves
  /// more than `reach_px` from the guess, does not converge, or correlates by less than 0.8.
  [[nodiscard]] static std::optional<Eigen::Vector2d> align(const cv::Mat& source, const Eigen::Vector2d& at,
                                                            const cv::Mat& target, const Eigen::Vector2d& guess,
                                                            double reach_px);
};

}  // namespace kinetrace::self_calibration
