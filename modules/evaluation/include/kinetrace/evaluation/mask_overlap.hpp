// Overlap of true and result masks in one frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::evaluation {

/// One instance of a frame.
struct MaskInstance {
  std::uint8_t label = 0;      ///< Of its pixels; neither kBackgroundLabel nor kIgnoreLabel.
  std::int64_t id = 0;         ///< The same in all frames; unique within a frame.
  std::uint16_t class_id = 0;  ///< Of KITTI MOTS; see core/detections.hpp.
};

/// The masks of a frame, disjoint as in KITTI MOTS. Pixels with kIgnoreLabel lie in truth's ignore region; pixels with
/// a label of no instance are background.
struct InstanceMasks {
  LabelView labels;  ///< May be empty if there are no instances.
  std::span<const MaskInstance> instances;
};

/// A KITTI MOTS image as labels.
struct MotsImage {
  std::vector<std::uint8_t> labels;  ///< Row-major, without gaps.
  int width = 0;
  int height = 0;
  std::vector<MaskInstance> instances;  ///< `id` is the pixel's value, class * 1000 + instance, in ascending order.

  [[nodiscard]] InstanceMasks masks() const { return {{labels.data(), width, height, width}, instances}; }
};

/// Numbers the values of a KITTI MOTS image: class * 1000 + instance, 0 background, 10000 ignore. Errors: kCapacity
/// (more than 254 instances).
[[nodiscard]] Result<MotsImage> label_mots_image(ImageView<const std::uint16_t> image);

/// Rows are truth's instances, columns the result's, in the order of InstanceMasks::instances.
struct MaskOverlap {
  Eigen::MatrixXd iou;            ///< Intersection over union, in [0, 1].
  Eigen::VectorXd truth_area_px;  ///< Zero for an instance without pixels.
  Eigen::VectorXd result_area_px;
  Eigen::VectorXd ignored;  ///< Fraction of each result mask within truth's ignore region, in [0, 1].
};

/// Errors: kInvalidArgument (images of different size, a label of no instance, a duplicate label or id).
[[nodiscard]] Result<MaskOverlap> overlap_masks(const InstanceMasks& truth, const InstanceMasks& result);

}  // namespace kinetrace::evaluation
