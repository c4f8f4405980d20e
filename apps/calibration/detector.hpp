// Finds the corners of a target in an image.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "target.hpp"

namespace kinetrace::calibration {

/// A point of the target in an image, pixel centres at integers.
struct Corner {
  int id = 0;  ///< Index into Target::points_m.
  Eigen::Vector2d px;
};

/// The target's corners in a pair of images, in the order of their ids.
struct BoardView {
  std::int64_t frame_index = 0;
  std::vector<Corner> left;
  std::vector<Corner> right;
};

class TargetDetector {
 public:
  TargetDetector() = default;
  TargetDetector(const TargetDetector&) = delete;
  TargetDetector& operator=(const TargetDetector&) = delete;
  TargetDetector(TargetDetector&&) = delete;
  TargetDetector& operator=(TargetDetector&&) = delete;
  virtual ~TargetDetector() = default;

  /// Corners in the order of their ids; none without a visible target.
  [[nodiscard]] virtual std::vector<Corner> detect(GrayView image) = 0;
  /// Both images. Chessboards that look the same upside down are numbered consistently.
  [[nodiscard]] virtual BoardView detect_pair(GrayView left, GrayView right) {
    return {.left = detect(left), .right = detect(right)};
  }
};

/// The detector of a kind of target. Errors: kInvalidArgument (unknown dictionary).
[[nodiscard]] Result<std::unique_ptr<TargetDetector>> make_detector(const Target& target);

// One kind each.
[[nodiscard]] std::unique_ptr<TargetDetector> make_chessboard_detector(const Target& target);
[[nodiscard]] Result<std::unique_ptr<TargetDetector>> make_charuco_detector(const Target& target);
[[nodiscard]] std::unique_ptr<TargetDetector> make_april_detector(const Target& target);

}  // namespace kinetrace::calibration
