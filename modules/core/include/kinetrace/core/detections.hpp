// Instance masks of one frame as segmentation delivers them, without identity over time.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace {

/// KITTI MOTS class numbers; other values are passed through. kUnknownClass marks motion segments.
inline constexpr std::uint16_t kUnknownClass = 0;
inline constexpr std::uint16_t kVehicleClass = 1;
inline constexpr std::uint16_t kPedestrianClass = 2;

/// One instance in one image.
struct Detection {
  std::uint8_t label = 0;  ///< Value of its pixels in the label image, 1..kMaxObjects.
  std::uint16_t class_id = kUnknownClass;
  float score = 1.F;
  PixelBox box_px;
  int area_px = 0;
  bool moving = false;  ///< By the evidence of segmentation: it has moved in this frame.
};

/// Detections of a stereo pair. `available` is false when segmentation had no result for this frame (a missing mask
/// file, a network still busy): tracks are then propagated. An available frame without detections means that nothing is
/// there, within `searched_px` and, with `moving_only`, among moving objects.
struct DetectionFrame {
  bool available = false;
  PixelBox
      searched_px;  ///< Searched part of the left image; empty: all of it. Objects cut by its border are not reported.
  bool moving_only = false;  ///< Only moving objects were searched for: a missing one may stand still.
  LabelView left_labels;
  std::span<const Detection> left;
  LabelView right_labels;  ///< Empty when the source gives no right masks: the tracker derives them.
  std::span<const Detection> right;

  /// True if an object with this box and class would have been found. Objects with a class are never found by motion
  /// alone.
  [[nodiscard]] bool has_looked_for(const PixelBox& box, std::uint16_t class_id) const noexcept {
    const PixelBox& part = searched_px;
    return available && (!moving_only || class_id == kUnknownClass) &&
           (part.empty() || (box.x0 >= part.x0 && box.y0 >= part.y0 && box.x1 <= part.x1 && box.y1 <= part.y1));
  }
};

}  // namespace kinetrace
