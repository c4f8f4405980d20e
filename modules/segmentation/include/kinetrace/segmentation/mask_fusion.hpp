// Fusion of a network's candidates and moving regions in one image.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::segmentation {

/// Least probability of a network's candidate: less probable ones are rejected even if they move, so the network need
/// not propose them.
inline constexpr float kMinCandidateProbability = 0.1F;

/// Instances of one image with their pixels. Both empty: image not segmented.
struct LabelledInstances {
  LabelView labels;
  std::span<const Detection> instances;
  std::span<const float> disparities_px{};  ///< Of the instances; empty if unknown.
};

/// Every hypothesis of an object has log-odds, and is accepted if they are positive:
/// - a network's candidate: the log-odds of its score, which is a probability, plus evidence from a moving region, in
///   proportion to their IoU;
/// - a moving region: the log-odds of a confirmed one, less a penalty for its part under accepted candidates. One that
///   overlaps an accepted person, and fits into one with it, is a part of that person: networks find the legs, or the
///   trunk alone.
/// An accepted candidate keeps its class and all its pixels, so that candidates divide a region under several of them.
/// An accepted region keeps its pixels outside accepted candidates, and has no class. Pixels that the network marks as
/// ignored stay ignored.
class MaskFusion {
 public:
  MaskFusion() = default;
  MaskFusion(const StereoGeometry& geometry, int max_objects, int min_area_px, Arena& arena);

  /// Replaces labels() and detections(). Label images have the geometry's size, or are empty. Returns the number of
  /// dropped objects: those beyond `max_objects`, the smallest, become kIgnoreLabel, those below `min_area_px`
  /// background.
  int fuse(const LabelledInstances& network, const LabelledInstances& motion) noexcept;

  [[nodiscard]] LabelView labels() const noexcept { return labels_; }
  /// Largest first.
  [[nodiscard]] std::span<const Detection> detections() const noexcept { return detections_.span(); }

 private:
  struct Object {
    bool is_region = false;  ///< Otherwise a candidate.
    std::uint8_t label = 0;  ///< In its source image.
    std::uint16_t class_id = kUnknownClass;
    float log_odds = 0.F;
    int area_px = 0;
    PixelBox box_px{};
    bool moving = false;
    std::uint8_t result = kBackgroundLabel;  ///< Label of its pixels.
  };

  /// Calls visit(row of `shared_px_`, column, y, x0, x1) for runs of pixels with constant labels in both images.
  template <typename Visit>
  void for_each_run(LabelView network, LabelView motion, Visit&& visit) const noexcept;
  void accept_candidates(std::span<const Detection> candidates, std::span<const Detection> regions) noexcept;
  void accept_regions(const LabelledInstances& motion) noexcept;
  /// The accepted candidate of the person of whom a region is a part; null if of none.
  [[nodiscard]] Object* person_with(const Detection& region, float disparity_px) noexcept;
  [[nodiscard]] int number_objects() noexcept;
  void draw(LabelView network, LabelView motion) noexcept;

  int min_area_px_ = 0;
  float baseline_m_ = 0.F;
  MutableLabelView labels_;
  FixedVector<Detection> detections_;
  FixedVector<Object> objects_;
  std::span<const std::uint8_t> blank_row_;  ///< Of an image that was not segmented.
  ImageView<std::int32_t> shared_px_;        ///< Pixels by label of motion (column) and of the network (row).
  ImageView<std::uint8_t> label_of_;         ///< Label of the result, likewise.
};

}  // namespace kinetrace::segmentation
