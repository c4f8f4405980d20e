// Two opinions of one image, a network's and that of motion, weighed into one.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::segmentation {

/// A network's candidates that are less probable than this are rejected, whatever moves: it need not propose them.
inline constexpr float kMinCandidateProbability = 0.1F;

/// Instances of one image with their pixels. Both empty: nobody has looked.
struct LabelledInstances {
  LabelView labels;
  std::span<const Detection> instances;
};

/// What may be an object gets log-odds, and is one where they are positive:
/// - a network's candidate: those of its score, which is a probability, and more the better a moving region fits it;
/// - a moving region: those of a confirmed one, and less the more of it is an accepted candidate's.
/// An accepted candidate keeps its class and all its pixels, so that a region on several of them is divided by them; an
/// accepted region has the pixels of it that no accepted candidate has, and no class. What belongs to nothing for the
/// network belongs to nothing.
class MaskFusion {
 public:
  MaskFusion() = default;
  MaskFusion(const StereoGeometry& geometry, int max_objects, int min_area_px, Arena& arena);

  /// Replaces labels() and detections(). Label images have the geometry's size, or are empty. Returns how many objects
  /// were dropped: those beyond `max_objects`, the smallest, become kIgnoreLabel, those below `min_area_px` background.
  int fuse(const LabelledInstances& network, const LabelledInstances& motion) noexcept;

  [[nodiscard]] LabelView labels() const noexcept { return labels_; }
  /// Largest first.
  [[nodiscard]] std::span<const Detection> detections() const noexcept { return detections_.span(); }

 private:
  struct Object {
    bool is_region = false;  ///< Else a candidate...
    std::uint8_t label = 0;  ///< ...and which, in the image that it comes from.
    std::uint16_t class_id = kUnknownClass;
    float log_odds = 0.F;
    int area_px = 0;
    std::uint8_t result = kBackgroundLabel;  ///< Label of its pixels.
  };

  /// Calls visit(row of `shared_px_`, column, y, x0, x1) for the runs of pixels that both images are uniform in.
  template <typename Visit>
  void for_each_run(LabelView network, LabelView motion, Visit&& visit) const noexcept;
  void accept_candidates(std::span<const Detection> candidates, std::span<const Detection> regions) noexcept;
  void accept_regions(std::span<const Detection> regions) noexcept;
  [[nodiscard]] int number_objects() noexcept;
  void draw(LabelView network, LabelView motion) noexcept;

  int min_area_px_ = 0;
  MutableLabelView labels_;
  FixedVector<Detection> detections_;
  FixedVector<Object> objects_;
  std::span<const std::uint8_t> blank_row_;  ///< Of an image that nobody has looked at.
  ImageView<std::int32_t> shared_px_;        ///< By label of motion (column) and of the network (row).
  ImageView<std::uint8_t> label_of_;         ///< The result's, likewise.
};

}  // namespace kinetrace::segmentation
