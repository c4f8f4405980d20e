// Smoothing of objects' paths over the frames that are still in the window.
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

/// A shorter path does not determine the motion.
inline constexpr std::size_t kMinPathFrames = 4;

/// Pose and velocity at the end of a smoothed path.
struct PathEnd {
  Se3 T_world_obj;
  Vector6d velocity = Vector6d::Zero();  ///< In the body's own axes (rad/s, m/s).
};

/// The object of a path.
struct PathObject {
  trajectory::PathPrior prior = {};
  bool reconstructed = true;  ///< Otherwise final poses are as uncertain as later ones.
};

/// An object's path is cut where its frame changes. Before a refined frame, the older part refers to the same point: it
/// is smoothed towards the newer part, but does not influence it, whose motion follows from the reconstructed points. A
/// replaced frame leaves two paths.
class TrajectoryBuffer {
 public:
  /// Memory: 1.8 kB per frame. The arena may turn out exhausted.
  TrajectoryBuffer(const trajectory::TrajectoryConfig& config, std::size_t frames, Arena& arena);

  /// A path of this object ends at this age: the object is not in the newer frame, or its frame changed there.
  [[nodiscard]] static bool ends_at(ResultRing& ring, std::uint32_t track_id, std::size_t age) noexcept;

  /// Smooths the path that ends at `age`, in its frames younger than `pending`; the parts of a path from the newest to
  /// the oldest. Returns the end of the newest part, once it is long enough.
  std::optional<PathEnd> smooth(ResultRing& ring, std::size_t pending, std::uint32_t track_id, std::size_t age,
                                const PathObject& object) noexcept;

 private:
  trajectory::TrajectorySmoother smoother_;
  std::span<trajectory::PathNode> nodes_;
};

}  // namespace kinetrace::pipeline
