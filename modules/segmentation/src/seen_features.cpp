#include "kinetrace/segmentation/seen_features.hpp"

namespace kinetrace::segmentation {

SeenFeatures::SeenFeatures(int max_features, Arena& arena) : by_slot_(arena, static_cast<std::size_t>(max_features)) {}

void SeenFeatures::remember(std::span<const Feature> features) noexcept {
  by_slot_.clear();
  by_slot_.resize(by_slot_.capacity());
  for (const Feature& feature : features) {
    by_slot_[feature.slot] = {feature.id, feature.left_px, feature.u_right_px};
  }
}

}  // namespace kinetrace::segmentation
