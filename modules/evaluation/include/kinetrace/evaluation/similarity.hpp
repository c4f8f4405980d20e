// Similarity of a true object and a track in one frame: 0 different, 1 identical.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"

namespace kinetrace::evaluation {

struct ObjectFrame;

/// A box in the image, edges in px, half open.
struct ImageBox {
  double x0 = 0.0;
  double y0 = 0.0;
  double x1 = 0.0;
  double y1 = 0.0;

  ImageBox() = default;
  ImageBox(double left, double top, double right, double bottom) : x0(left), y0(top), x1(right), y1(bottom) {}
  explicit ImageBox(const PixelBox& box) : x0(box.x0), y0(box.y0), x1(box.x1), y1(box.y1) {}
  [[nodiscard]] double area() const noexcept { return x1 > x0 && y1 > y0 ? (x1 - x0) * (y1 - y0) : 0.0; }
};

/// Intersection over union; 0 if one of them is empty.
[[nodiscard]] double box_iou(const ImageBox& a, const ImageBox& b);

/// Each of these sets `frame.similarity` from `frame.truth` and `frame.tracks`.

/// Intersection over union of the masks, and `covers` of the tracks. Instances of `truth` have the objects' ids, those
/// of `tracks` the tracks' ids. A track without a mask is compared by its box in `track_boxes` (by index of the track;
/// may be empty) with the box of the object's mask. Errors: those of overlap_masks.
[[nodiscard]] Status compare_masks(const InstanceMasks& truth, const InstanceMasks& tracks,
                                   const std::vector<ImageBox>& track_boxes, ObjectFrame& frame);

/// Intersection over union of boxes in the image, by index of object and track.
void compare_boxes(const std::vector<ImageBox>& truth_boxes, const std::vector<ImageBox>& track_boxes,
                   ObjectFrame& frame);

/// 1 at the same place, 0.5 at a distance of `gate_m`, 0 from twice that on. A position that is not finite has
/// similarity 0.
void compare_centres(const std::vector<Eigen::Vector3d>& truth_m, const std::vector<Eigen::Vector3d>& tracks_m,
                     double gate_m, ObjectFrame& frame);

}  // namespace kinetrace::evaluation
