// The points of one body and their observations in the window, in the layout that bundle adjustment reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/rig_correction.hpp"

namespace kinetrace::sfm {

/// State of a point besides its position.
struct PointState {
  std::uint32_t id = 0;            ///< Id of its feature.
  std::uint16_t slot = 0;          ///< Slot of that feature.
  std::uint16_t observations = 0;  ///< Observations over its whole life.
  std::uint32_t seen = 0;          ///< Window columns that observe it, with or without a position.
  std::uint32_t observed = 0;      ///< Of these, columns with own observations; the others are merged ones.
  float error_px = 0.F;            ///< RMS reprojection error in the window.
  std::uint8_t intensity = 0;
  bool positioned = false;  ///< False: observed, but not yet triangulated.
};

/// Rows 0..size()-1, each a point with one observation per window column; at most `max_points` rows. Removing a row
/// moves the last one into its place. Features find their row by slot and id, so a reused slot never finds the point of
/// an earlier feature.
class PointMap {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  PointMap() = default;
  PointMap(Arena& arena, std::size_t max_points, std::size_t max_features, std::size_t window_frames);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return states_.size(); }
  [[nodiscard]] bool full() const noexcept { return size_ == states_.size(); }

  [[nodiscard]] std::size_t find(const Feature& feature) const noexcept;
  /// Creates a row for a feature that has none, without position or observations. kNone at capacity.
  [[nodiscard]] std::size_t create(const Feature& feature) noexcept;
  void remove(std::size_t row) noexcept;
  void clear() noexcept;

  /// Records an observation in window column `column`.
  void observe(std::size_t row, std::size_t column, const BundleObservation& observation) noexcept;
  /// Combines `observation` with that of column `column`, weighted, or fills in a missing one. The result's weight is
  /// at most `max_inverse_sigma_px`. Not counted as an observation.
  void merge(std::size_t row, std::size_t column, const BundleObservation& observation,
             float max_inverse_sigma_px) noexcept;
  void forget(std::size_t row, std::size_t column) noexcept {
    states_[row].seen &= ~(1U << column);
    states_[row].observed &= ~(1U << column);
  }
  /// Scales the inverse sigmas of all observations, after a change of the noise scale.
  void scale_weights(float factor) noexcept;
  /// Converts all right observations, and the mean rows, to a new correction of the rig.
  void remeasure(const RigChange& change) noexcept;
  /// Drops window column `column`; later columns move down by one and the last one becomes empty.
  void remove_column(std::size_t column) noexcept;

  [[nodiscard]] PointState& state(std::size_t row) noexcept { return states_[row]; }
  [[nodiscard]] const PointState& state(std::size_t row) const noexcept { return states_[row]; }
  [[nodiscard]] BundlePoint& point(std::size_t row) noexcept { return points_[row]; }
  [[nodiscard]] const BundlePoint& point(std::size_t row) const noexcept { return points_[row]; }
  [[nodiscard]] std::span<const BundleObservation> observations(std::size_t row) const noexcept {
    return table_.subspan(row * window_frames_, window_frames_);
  }
  [[nodiscard]] std::span<BundlePoint> points() noexcept { return points_.first(size_); }
  [[nodiscard]] std::span<const BundleObservation> table() const noexcept {
    return table_.first(size_ * window_frames_);
  }

 private:
  static constexpr std::uint16_t kNoRow = 0xFFFF;
  std::span<PointState> states_;
  std::span<BundlePoint> points_;
  std::span<BundleObservation> table_;
  std::span<std::uint16_t> row_of_slot_;
  std::size_t window_frames_ = 0;
  std::size_t size_ = 0;
};

}  // namespace kinetrace::sfm
