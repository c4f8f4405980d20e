#include "feature_population.hpp"

#include <algorithm>
#include <cmath>

#include "mask_membership.hpp"

namespace kinetrace::features {
namespace {

// A body with fewer features accepts those at its border.
constexpr int kFewFeatures = 10;
// A body with fewer features accepts any, to have a position at all.
constexpr int kMinFeatures = 3;

/// Live features, by body.
std::array<int, 256> count_features(std::span<const FeatureSlot> slots) noexcept {
  std::array<int, 256> population{};
  for (const FeatureSlot& slot : slots) {
    population[slot.feature.body] += slot.state == SlotState::kAlive ? 1 : 0;
  }
  return population;
}

/// True if a feature's patch represents its body; less strict for bodies with few others.
bool fit_for_body(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body, int others) noexcept {
  return labels.empty() || others < kMinFeatures ||
         (clear_of_other_objects(labels, position_px, body) &&
          (others < kFewFeatures || well_inside(labels, position_px, body)));
}

}  // namespace

FeaturePopulation::FeaturePopulation(const FeatureConfig& config, Arena& arena, int width_px, int height_px)
    : config_(config),
      corner_finder_(config, arena, width_px, height_px),
      occupancy_(arena, width_px, height_px, config.min_distance_px),
      order_(arena.take<std::uint16_t>(static_cast<std::size_t>(config.max_features))) {}

std::size_t FeaturePopulation::count_corners(const Plane& image, Workers* workers) noexcept {
  occupancy_.clear();
  corner_finder_.clear();
  return corner_finder_.find(image, {}, occupancy_, workers).size();
}

std::span<std::uint16_t> FeaturePopulation::list_alive(std::span<const FeatureSlot> slots) noexcept {
  std::size_t alive = 0;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (slots[i].state == SlotState::kAlive) {
      order_[alive++] = static_cast<std::uint16_t>(i);
    }
  }
  return order_.first(alive);
}

void FeaturePopulation::reconcile_with(LabelView labels, std::span<FeatureSlot> slots,
                                       FeatureCounters& counters) const noexcept {
  if (labels.empty()) {
    for (FeatureSlot& slot : slots) {
      if (slot.state == SlotState::kAlive && slot.feature.body != kBackgroundLabel) {
        slot.end(counters.lost_body);
      }
    }
    return;
  }
  std::array<int, 256> population = count_features(slots);
  for (FeatureSlot& slot : slots) {
    const Feature& feature = slot.feature;
    if (slot.state == SlotState::kAlive &&
        (!still_member(labels, feature.left_px, feature.body, config_.mask_border_px) ||
         !fit_for_body(labels, feature.left_px, feature.body, population[feature.body] - 1))) {
      --population[feature.body];
      slot.end(counters.lost_body);
    }
  }
}

int FeaturePopulation::most_features(std::uint8_t body) const noexcept {
  const int configured = body == kBackgroundLabel ? config_.max_background_features : config_.max_features_per_object;
  return std::min(configured, static_cast<int>(std::ceil(limit_ * configured)));
}

void FeaturePopulation::thin_out(std::span<FeatureSlot> slots, FeatureCounters& counters) noexcept {
  const std::span<std::uint16_t> alive = list_alive(slots);
  // Ids ascend with time: the smaller id is the older feature.
  std::sort(alive.begin(), alive.end(),
            [slots](std::uint16_t a, std::uint16_t b) { return slots[a].feature.id < slots[b].feature.id; });
  occupancy_.clear();
  corner_finder_.clear();
  std::array<int, 256> population{};
  for (const std::uint16_t index : alive) {
    FeatureSlot& slot = slots[index];
    const Eigen::Vector2f& position = slot.feature.left_px;
    if (population[slot.feature.body] >= most_features(slot.feature.body)) {
      slot.end(counters.lost_limit);
      continue;
    }
    if (occupancy_.coincides(position.x(), position.y())) {
      slot.end(counters.lost_crowded);
      continue;
    }
    ++population[slot.feature.body];
    occupancy_.add(position);
    corner_finder_.occupy(position, slot.feature.body);
  }
}

void FeaturePopulation::mask_patches(LabelView labels, std::span<FeatureSlot> slots, Workers* workers) noexcept {
  const std::span<const std::uint16_t> alive = list_alive(slots);
  in_pieces(workers, alive.size(), kFeaturesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      FeatureSlot& slot = slots[alive[i]];
      slot.own = labels.empty() ? kWholePatch : own_pixels(labels, slot.feature.left_px, slot.feature.body);
    }
  });
}

std::span<const std::uint16_t> FeaturePopulation::create(const Plane& image, LabelView labels,
                                                         const FeatureFrontEnd::PredictedMasks& predicted_masks,
                                                         std::span<FeatureSlot> slots, FeatureCounters& counters,
                                                         Workers* workers) noexcept {
  const std::span<const Corner> corners = corner_finder_.find(image, labels, occupancy_, workers);
  std::array<int, 256> population = count_features(slots);
  auto free_slot = slots.begin();
  std::size_t created = 0;
  for (const Corner& corner : corners) {
    if (occupancy_.near(corner.x, corner.y)) {
      continue;  // Too close to a new corner across the border of the bucket.
    }
    if (predicted_masks[corner.body] ||
        !fit_for_body(labels, {corner.x, corner.y}, corner.body, population[corner.body])) {
      continue;
    }
    free_slot = std::find_if(free_slot, slots.end(), [](const FeatureSlot& s) { return s.state == SlotState::kFree; });
    if (free_slot == slots.end() || population[corner.body] >= most_features(corner.body)) {
      ++counters.dropped;
      continue;
    }
    ++population[corner.body];
    create_one(*free_slot, static_cast<std::uint16_t>(free_slot - slots.begin()), corner, image, labels);
    ++counters.created;
    order_[created++] = free_slot->feature.slot;
    occupancy_.add(free_slot->feature.left_px);
  }
  return order_.first(created);
}

void FeaturePopulation::create_one(FeatureSlot& slot, std::uint16_t index, const Corner& corner, const Plane& image,
                                   LabelView labels) noexcept {
  const Eigen::Vector2f position = corner.position_px();
  slot.state = SlotState::kAlive;
  slot.rejected = false;
  slot.from_reference = kNoWarp;
  slot.zoom = 1.F;
  slot.to_right = kNoWarp;
  slot.own = labels.empty() ? kWholePatch : own_pixels(labels, position, corner.body);
  slot.reference.take(image, position.x(), position.y());
  Feature& feature = slot.feature;
  feature = {};
  feature.id = next_id_++;
  feature.slot = index;
  feature.body = corner.body;
  feature.left_px = position;
  feature.previous_left_px = position;
}

}  // namespace kinetrace::features
