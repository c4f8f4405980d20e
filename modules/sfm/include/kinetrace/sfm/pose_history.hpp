// Poses of the last frames. Those in the window follow its refinement, dropped ones follow a neighbour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"

namespace kinetrace::sfm {

/// A ring of the last `capacity` frames of a body. A frame's pose is stored relative to a window column (its own, or a
/// neighbour's if it was dropped as redundant), so refinement improves it until that column leaves the window; then it
/// is frozen.
class PoseHistory {
 public:
  PoseHistory() = default;
  PoseHistory(Arena& arena, std::size_t capacity) : entries_(arena.take<Entry>(capacity)) {}

  void clear() noexcept { size_ = 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

  /// Appends the newest frame, anchored to window column `column` with identity offset.
  void push(const FinalisedPose& pose, std::size_t column) noexcept;
  /// Frame `age` frames ago (0 = newest, < size()), resolved against the window's present poses.
  [[nodiscard]] FinalisedPose at(std::size_t age, std::span<const Se3> T_body_cam) const noexcept;
  /// Sets the newest frame's results.
  void update_newest(BodyStatus status, const Matrix6d& covariance, int inliers) noexcept;

  /// Before window column `column` is dropped: entries tied to it freeze or, if `target_column` is a column, are tied
  /// to that one. Afterwards columns above `column` have moved down by one.
  void drop_column(std::size_t column, std::span<const Se3> T_body_cam, std::size_t target_column) noexcept;
  /// Freezes every entry: the window is about to be cleared.
  void freeze(std::span<const Se3> T_body_cam) noexcept;

  static constexpr std::size_t kFrozen = static_cast<std::size_t>(-1);

 private:
  struct Entry {
    FinalisedPose pose;  ///< Its T_body_cam counts when frozen.
    std::size_t column = kFrozen;
    Se3 T_column_cam;
  };
  [[nodiscard]] Entry& entry(std::size_t age) noexcept {
    return entries_[(head_ + entries_.size() - age) % entries_.size()];
  }
  [[nodiscard]] const Entry& entry(std::size_t age) const noexcept {
    return entries_[(head_ + entries_.size() - age) % entries_.size()];
  }
  static void freeze(Entry& entry, std::span<const Se3> T_body_cam) noexcept;

  std::span<Entry> entries_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace kinetrace::sfm
