#include "motion_neighbours.hpp"

#include <array>
#include <span>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::features {
namespace {

constexpr std::size_t kNearest = 5;
constexpr float kReach_px = 120.F;

}  // namespace

void MotionNeighbours::clear() noexcept {
  moved_.clear();
  postponed_.clear();
  followed_.fill(0);
  failed_.fill(0);
}

void MotionNeighbours::add(const FeatureSlot& slot) noexcept {
  const Feature& feature = slot.feature;
  // Capacity is the number of slots, here and below.
  static_cast<void>(moved_.push_back({feature.previous_left_px, feature.left_px, slot.zoom, feature.body}));
  ++followed_[feature.body];
}

void MotionNeighbours::postpone(const Feature& feature, TrackOutcome outcome) noexcept {
  static_cast<void>(postponed_.push_back({feature.slot, outcome}));
  // A feature that left the image is no evidence for or against the predictions.
  failed_[feature.body] += outcome == TrackOutcome::kOutside ? 0 : 1;
}

bool MotionNeighbours::expected(const Feature& feature, TrackStart& start) const noexcept {
  std::array<float, kNearest> distances{};
  std::array<const Moved*, kNearest> nearest{};
  std::size_t count = 0;
  for (const Moved& moved : moved_) {
    const float distance = (moved.from - feature.left_px).squaredNorm();
    if (moved.body != feature.body || distance > kReach_px * kReach_px ||
        (count == kNearest && distance >= distances[kNearest - 1])) {
      continue;
    }
    std::size_t place = count < kNearest ? count++ : kNearest - 1;
    for (; place > 0 && distances[place - 1] > distance; --place) {
      distances[place] = distances[place - 1];
      nearest[place] = nearest[place - 1];
    }
    distances[place] = distance;
    nearest[place] = &moved;
  }
  if (count == 0) {
    return false;
  }
  std::array<float, kNearest> x{};
  std::array<float, kNearest> y{};
  std::array<float, kNearest> zoom{};
  for (std::size_t i = 0; i < count; ++i) {
    const Moved& neighbour = *nearest[i];
    const Eigen::Vector2f position = neighbour.to + neighbour.zoom * (feature.left_px - neighbour.from);
    x[i] = position.x();
    y[i] = position.y();
    zoom[i] = neighbour.zoom;
  }
  start.position_px = {median(std::span(x).first(count)), median(std::span(y).first(count))};
  start.zoom = median(std::span(zoom).first(count));
  start.reach = Reach::kNear;
  return true;
}

}  // namespace kinetrace::features
