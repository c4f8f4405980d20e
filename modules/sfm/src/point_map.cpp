#include "kinetrace/sfm/point_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kinetrace::sfm {

PointMap::PointMap(Arena& arena, std::size_t max_points, std::size_t max_features, std::size_t window_frames)
    : states_(arena.take<PointState>(max_points)),
      points_(arena.take<BundlePoint>(max_points)),
      table_(arena.take<BundleObservation>(max_points * window_frames)),
      row_of_slot_(arena.take<std::uint16_t>(max_features)),
      window_frames_(window_frames) {
  clear();
}

std::size_t PointMap::find(const Feature& feature) const noexcept {
  const std::uint16_t row = row_of_slot_[feature.slot];
  return row != kNoRow && states_[row].id == feature.id ? row : kNone;
}

std::size_t PointMap::create(const Feature& feature) noexcept {
  if (full()) {
    return kNone;
  }
  const std::size_t row = size_++;
  states_[row] = PointState{.id = feature.id, .slot = feature.slot, .intensity = feature.intensity};
  points_[row] = BundlePoint{};
  row_of_slot_[feature.slot] = static_cast<std::uint16_t>(row);
  return row;
}

void PointMap::remove(std::size_t row) noexcept {
  assert(row < size_);
  // The slot may already belong to a newer feature's point.
  if (row_of_slot_[states_[row].slot] == row) {
    row_of_slot_[states_[row].slot] = kNoRow;
  }
  const std::size_t last = --size_;
  if (row == last) {
    return;
  }
  if (row_of_slot_[states_[last].slot] == last) {
    row_of_slot_[states_[last].slot] = static_cast<std::uint16_t>(row);
  }
  states_[row] = states_[last];
  points_[row] = points_[last];
  std::copy_n(table_.data() + last * window_frames_, window_frames_, table_.data() + row * window_frames_);
}

void PointMap::clear() noexcept {
  size_ = 0;
  std::fill(row_of_slot_.begin(), row_of_slot_.end(), kNoRow);
}

void PointMap::observe(std::size_t row, std::size_t column, const BundleObservation& observation) noexcept {
  table_[row * window_frames_ + column] = observation;
  states_[row].seen |= 1U << column;
  states_[row].observed |= 1U << column;
  if (states_[row].observations < 0xFFFF) {
    ++states_[row].observations;
  }
}

void PointMap::merge(std::size_t row, std::size_t column, const BundleObservation& observation,
                     float max_inverse_sigma_px) noexcept {
  BundleObservation& kept = table_[row * window_frames_ + column];
  if ((states_[row].seen >> column & 1U) == 0) {
    kept = observation;
    states_[row].seen |= 1U << column;
    return;
  }
  const float kept_weight = kept.inverse_sigma_px * kept.inverse_sigma_px;
  const float weight = observation.inverse_sigma_px * observation.inverse_sigma_px;
  const float share = weight / (kept_weight + weight);
  kept.u_left_px += share * (observation.u_left_px - kept.u_left_px);
  kept.v_px += share * (observation.v_px - kept.v_px);
  if (std::isnan(kept.u_right_px)) {
    kept.u_right_px = observation.u_right_px;
  } else if (!std::isnan(observation.u_right_px)) {
    kept.u_right_px += share * (observation.u_right_px - kept.u_right_px);
  }
  kept.inverse_sigma_px = std::min(std::sqrt(kept_weight + weight), max_inverse_sigma_px);
}

void PointMap::scale_weights(float factor) noexcept {
  for (BundleObservation& observation : table_.first(size_ * window_frames_)) {
    observation.inverse_sigma_px *= factor;
  }
}

void PointMap::remeasure(const RigChange& change) noexcept {
  for (BundleObservation& o : table_.first(size_ * window_frames_)) {
    if (std::isnan(o.u_right_px)) {
      continue;
    }
    const Eigen::Vector2f before(o.u_right_px, o.v_px);
    const Eigen::Vector2f moved =
        change.right_px(before.cast<double>(), static_cast<double>(o.u_left_px - o.u_right_px)).cast<float>() - before;
    o.u_right_px += moved.x();
    o.v_px += 0.5F * moved.y();  // The mean of both rows.
  }
}

void PointMap::remove_column(std::size_t column) noexcept {
  const std::uint32_t below = (1U << column) - 1U;
  const auto without = [below](std::uint32_t columns) { return (columns & below) | ((columns >> 1U) & ~below); };
  for (std::size_t row = 0; row < size_; ++row) {
    BundleObservation* first = table_.data() + row * window_frames_;
    std::copy(first + column + 1, first + window_frames_, first + column);
    states_[row].seen = without(states_[row].seen);
    states_[row].observed = without(states_[row].observed);
  }
}

}  // namespace kinetrace::sfm
