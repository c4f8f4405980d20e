// Run-length masks drawn into one label image.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "kinetrace/segmentation/instance_image.hpp"

namespace kinetrace::segmentation {

/// Draws the masks of one image, earlier ones over later ones, and turns them into detections.
class MaskCanvas {
 public:
  /// Most masks of one image; those beyond are dropped and counted.
  static constexpr std::size_t kMaxMasks = 256;

  MaskCanvas() = default;
  MaskCanvas(const StereoGeometry& geometry, int max_objects, Arena& arena);

  /// Replaces what was drawn before.
  void draw(std::span<const RunLengthMask> masks) noexcept;
  /// The same for a network's candidates, strongest first. One that lies mostly on earlier ones of its class is another
  /// mask of the same object: the rest of it is ignored (Kirillov et al. 2019, Panoptic Feature Pyramid Networks, sec.
  /// 3). One mostly on a mask of another class is in front and drawn over it, as a person before a vehicle.
  void draw_candidates(std::span<const RunLengthMask> masks) noexcept;
  /// Numbers the drawn masks, or those written to `drawn()`; returns the number of dropped masks, including those
  /// skipped by draw().
  int finish(const SegmentationConfig& config, InstanceRelabeler& relabeler) noexcept;

  /// Position in the list of masks, from 1, for every pixel.
  [[nodiscard]] ImageView<std::uint16_t> drawn() const noexcept { return values_; }
  [[nodiscard]] std::size_t mask_count() const noexcept { return listed_.size(); }
  [[nodiscard]] LabelView labels() const noexcept { return labels_; }
  [[nodiscard]] std::span<const Detection> detections() const noexcept { return detections_.span(); }

 private:
  template <typename OverlapOf>
  void draw_with(std::span<const RunLengthMask> masks, const OverlapOf& overlap_of) noexcept;

  ImageView<std::uint16_t> values_;
  MutableLabelView labels_;
  FixedVector<Detection> detections_;
  FixedVector<ListedInstance> listed_;
  std::size_t not_drawn_ = 0;
};

}  // namespace kinetrace::segmentation
