// Converts the values of an instance image to labels 1..n with boxes and areas.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/instance_masks.hpp"

namespace kinetrace::segmentation {

/// Encoding of a mask file's pixels.
enum class MaskEncoding : std::uint8_t {
  kMots,      ///< 16 bit, KITTI MOTS: class * 1000 + instance; 10000 = ignore; 0 = background.
  kInstance,  ///< 8 bit: instance of unknown class; 255 = ignore; 0 = background.
  kListed,    ///< Position in a list of instances, from 1; 0 = background.
};

/// List entry of an instance; class kIgnoreClass = ignore.
struct ListedInstance {
  std::uint16_t class_id = kUnknownClass;
  float score = 1.F;
};

/// Renumbers instances by area, largest first, which discards the numbering of the file. Instances beyond `max_objects`
/// become kIgnoreLabel (objects that are not tracked), those below `min_area_px` background. At most kMaxValues
/// different values a file; further ones become kIgnoreLabel.
class InstanceRelabeler {
 public:
  static constexpr std::size_t kMaxValues = 1024;

  InstanceRelabeler() = default;
  explicit InstanceRelabeler(Arena& arena);

  /// Writes `labels` and the kept instances; returns the number of dropped ones. `source` and `labels` have the same
  /// size; `detections` has room for `max_objects`. `listed` has all values of MaskEncoding::kListed.
  int relabel(ImageView<const std::uint16_t> source, MaskEncoding encoding, int max_objects, int min_area_px,
              MutableLabelView labels, FixedVector<Detection>& detections,
              std::span<const ListedInstance> listed = {}) noexcept;
  /// True if all instances of the last image are to be ignored.
  [[nodiscard]] bool ignores_all() const noexcept { return ignores_all_; }
  /// True if the last image was a camera's: more values than objects that a frame may hold, in runs of few pixels.
  [[nodiscard]] bool is_picture() const noexcept;

 private:
  struct Instance {
    std::uint16_t value = 0;
    PixelBox box_px;
    int area_px = 0;
  };
  void collect(ImageView<const std::uint16_t> source) noexcept;
  int number(MaskEncoding encoding, std::span<const ListedInstance> listed, int max_objects, int min_area_px,
             FixedVector<Detection>& detections) noexcept;

  std::span<std::uint16_t> index_of_value_;  ///< 0 = not seen, else 1 + index in `instances_`.
  FixedVector<Instance> instances_;
  int values_beyond_capacity_ = 0;
  int runs_ = 0;  ///< Of equal values in a row.
  bool ignores_all_ = false;
};

}  // namespace kinetrace::segmentation
