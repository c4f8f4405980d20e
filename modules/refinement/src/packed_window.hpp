// A bundle window laid out for the kernel: in the anchor camera's frame, points in groups of eight.
#pragma once

#include <cstdint>
#include <span>

#include "bundle_kernel.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/bundle.hpp"

namespace kinetrace::refinement {

/// Storage for windows of up to `max_frames` x `max_points`, with the window packed last.
struct PackedWindow {
  PackedWindow() = default;
  PackedWindow(Arena& arena, int max_frames, int max_points);

  /// Number of points in use; beyond `max_points` a window cannot be packed.
  [[nodiscard]] static int count_points(const BundleWindow& window);
  /// Packs a checked window that fits the storage. The frame of the oldest fixed pose is the anchor.
  void pack(const BundleWindow& window);
  /// Applies the changes since `pack` to the window's free poses and points. Unchanged values keep their bits.
  void unpack(BundleWindow& window) const;

  int frames = 0;
  int free_frames = 0;
  int groups = 0;
  int points = 0;
  Se3 T_body_anchor;
  std::span<int> free_index;  ///< Per frame; -1 where fixed.
  std::span<Se3> T_cam_anchor;
  std::span<std::uint64_t> order;  ///< Per packed point: its frames (high half), its index in the window (low half).
  std::span<PointGroup> group;
  std::span<ObservationLanes> observations;
  std::span<PointLanes> initial;  ///< As packed.
  std::span<PointLanes> current;
};

}  // namespace kinetrace::refinement
