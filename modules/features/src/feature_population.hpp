// Creation and removal of features, by the masks and by each body's limit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "corner_finder.hpp"
#include "feature_slot.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/features/feature_config.hpp"
#include "kinetrace/features/feature_front_end.hpp"

namespace kinetrace::features {

/// The steps of FeatureFrontEnd::replenish: reconcile, thin out, mask patches, create. They modify the given slots.
class FeaturePopulation {
 public:
  FeaturePopulation() = default;
  FeaturePopulation(const FeatureConfig& config, Arena& arena, int width_px, int height_px);

  /// As FeatureFrontEnd::limit.
  void limit(double part) noexcept { limit_ = part; }
  /// As FeatureFrontEnd::count_corners.
  [[nodiscard]] std::size_t count_corners(const Plane& image, Workers* workers) noexcept;

  /// Ends features that lie on another body by now, or whose patch contains too little of their own.
  void reconcile_with(LabelView labels, std::span<FeatureSlot> slots, FeatureCounters& counters) const noexcept;
  /// Ends the youngest where a body has too many, or two features have met.
  void thin_out(std::span<FeatureSlot> slots, FeatureCounters& counters) noexcept;
  /// Stores which pixels around each feature are its body's own, for later alignment.
  void mask_patches(LabelView labels, std::span<FeatureSlot> slots, Workers* workers) noexcept;
  /// After thin_out(): creates features in free slots, without their right matches. Returns their slots, valid until
  /// the next call of any function here.
  [[nodiscard]] std::span<const std::uint16_t> create(const Plane& image, LabelView labels,
                                                      const FeatureFrontEnd::PredictedMasks& predicted_masks,
                                                      std::span<FeatureSlot> slots, FeatureCounters& counters,
                                                      Workers* workers) noexcept;

 private:
  [[nodiscard]] int most_features(std::uint8_t body) const noexcept;
  void create_one(FeatureSlot& slot, std::uint16_t index, const Corner& corner, const Plane& image,
                  LabelView labels) noexcept;
  /// Writes the slots of live features to `order_`.
  [[nodiscard]] std::span<std::uint16_t> list_alive(std::span<const FeatureSlot> slots) noexcept;

  FeatureConfig config_;
  CornerFinder corner_finder_;
  OccupancyMap occupancy_;
  std::span<std::uint16_t> order_;  ///< Slots to process.
  std::uint32_t next_id_ = 1;
  double limit_ = 1.0;  ///< Part of the features configured for each body.
};

}  // namespace kinetrace::features
