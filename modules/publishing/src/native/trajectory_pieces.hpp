// Collects final poses into pieces of trajectories.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace.h"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/publishing/published_frame.hpp"

namespace kinetrace::publishing {

/// Consecutive poses of one object. Points into the collector until its next call.
struct TrajectoryPart {
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;
  bool finished = false;
  std::uint32_t first_pose = 0;  ///< Counted from the object's first.
  std::span<kinetrace_TrajectoryPose> poses;
};

/// Bounded: at the capacity, the least recently updated trajectory is published early, and its pose count is lost.
class TrajectoryPieces {
 public:
  static constexpr std::size_t kMaxPoses = 64;  ///< Bound of TrajectoryPiece in the IDL.

  TrajectoryPieces(const PublishConfig& config, Arena& arena);

  /// Takes an event and calls `send(part)` for every part that it completes.
  template <typename Send>
  void add(const TrajectoryEvent& event, Send&& send) noexcept {
    Open* open = find(event.track_id);
    if (event.ends) {
      if (open != nullptr) {  // Null: published earlier for lack of room.
        TrajectoryPart last = take_piece(*open);
        last.finished = true;
        send(last);
        *open = {};
      }
      return;
    }
    if (open == nullptr) {
      open = &least_recently_updated();  // Free slots come first.
      if (open->count > 0) {
        send(take_piece(*open));
      }
      begin(*open, event);
    }
    append(*open, event);
    if (open->count == poses_per_piece_) {
      send(take_piece(*open));
    }
  }

 private:
  struct Open {
    std::uint32_t track_id = 0;  ///< 0: free.
    std::uint16_t class_id = 0;
    std::uint32_t first_pose = 0;
    std::size_t count = 0;
    std::uint64_t last_update = 0;  ///< Counts events.
    std::array<kinetrace_TrajectoryPose, kMaxPoses> poses{};
  };

  [[nodiscard]] Open* find(std::uint32_t track_id) noexcept;
  [[nodiscard]] Open& least_recently_updated() noexcept;
  static void begin(Open& open, const TrajectoryEvent& event) noexcept;
  void append(Open& open, const TrajectoryEvent& event) noexcept;
  /// The collected poses; `open` continues behind them.
  static TrajectoryPart take_piece(Open& open) noexcept;

  std::span<Open> open_;
  std::size_t poses_per_piece_;
  std::uint64_t events_ = 0;
};

}  // namespace kinetrace::publishing
