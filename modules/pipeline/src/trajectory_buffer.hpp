// The paths of objects through the frames that are still in the window, made smooth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/trajectory/trajectory_smoother.hpp"
#include "result_ring.hpp"

namespace kinetrace::pipeline {

/// A shorter path has not shown how the object moves.
inline constexpr std::size_t kMinPathFrames = 4;

/// An object's frame had been guessed when its reconstruction began, and is known now.
struct FrameCorrection {
  Se3 T_provisional_known;
  std::size_t frames = 0;  ///< So many before this one were reported in the guessed frame.
};

/// Where a smoothed path has led to, and how it goes on.
struct PathEnd {
  Se3 T_world_obj;
  Vector6d velocity = Vector6d::Zero();  ///< In the body's own axes (rad/s, m/s).
};

/// An object's path is cut where its frame changes. Of a frame that was refined, the part before is about the same
/// point, so it is made to lead to the part after; but it teaches that nothing: how the object moves shows in its
/// points. A frame that was replaced leaves two paths.
class TrajectoryBuffer {
 public:
  /// Memory: 1.8 kB a frame. The arena may turn out exhausted.
  TrajectoryBuffer(const trajectory::TrajectoryConfig& config, std::size_t frames, Arena& arena);

  /// A path of this object ends at this age: the object is not in the newer frame, or its frame changed there.
  [[nodiscard]] static bool ends_at(ResultRing& ring, std::uint32_t track_id, std::size_t age) noexcept;

  /// Smooths the path that ends at `age`, of those of its frames that are younger than `pending`; parts are to be
  /// smoothed from the newest to the oldest. Says where the newest one leads, once it is long enough to show.
  std::optional<PathEnd> smooth(ResultRing& ring, std::size_t pending, std::uint32_t track_id, std::size_t age,
                                bool at_rest) noexcept;

  /// Tells the last frames of an object, the newest left out, in the frame that is known by now. What is older than
  /// `pending` has been published, and stays.
  static void correct(ResultRing& ring, std::size_t pending, std::uint32_t track_id,
                      const FrameCorrection& correction) noexcept;

 private:
  trajectory::TrajectorySmoother smoother_;
  std::span<trajectory::PathNode> nodes_;
};

}  // namespace kinetrace::pipeline
