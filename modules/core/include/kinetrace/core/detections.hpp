// Instance masks of one frame, as segmentation delivers them: no identity over time.
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
  std::uint8_t label = 0;  ///< Its pixels' value in the label image, 1..kMaxObjects.
  std::uint16_t class_id = kUnknownClass;
  float score = 1.F;
  PixelBox box_px;
  int area_px = 0;
};

/// Detections of a stereo pair. `available` is false when segmentation had nothing to say about this frame (a missing
/// mask file, a network still busy): tracks are then propagated. An available frame with no detections says "nothing is
/// here". Where only a part was looked at, or only for what moves, that holds for no more.
struct DetectionFrame {
  bool available = false;
  PixelBox
      searched_px;  ///< Part of the left image that was looked at; empty: all of it. What is cut by it is not reported.
  bool moving_only = false;  ///< Only what moves was looked for: what is not here may stand still.
  LabelView left_labels;
  std::span<const Detection> left;
  LabelView right_labels;  ///< Empty when the source gives no right masks: the tracker derives them.
  std::span<const Detection> right;

  /// True if an object with this box and class would have been found; what has a class, not by its motion.
  [[nodiscard]] bool has_looked_for(const PixelBox& box, std::uint16_t class_id) const noexcept {
    const PixelBox& part = searched_px;
    return available && (!moving_only || class_id == kUnknownClass) &&
           (part.empty() || (box.x0 >= part.x0 && box.y0 >= part.y0 && box.x1 <= part.x1 && box.y1 <= part.y1));
  }
};

}  // namespace kinetrace
