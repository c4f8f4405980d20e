// Results on their way from the pipeline's thread to the publisher's.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/latest_value.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/event_queue.hpp"
#include "kinetrace/publishing/publish_config.hpp"
#include "kinetrace/publishing/published_frame.hpp"

namespace kinetrace::publishing {

/// What the mailbox has counted so far.
struct MailboxCounters {
  std::uint64_t offered = 0;     ///< Frames.
  std::uint64_t superseded = 0;  ///< Of these, replaced by a newer one before the publisher fetched them.
  std::uint64_t trajectory_poses_dropped = 0;
};

/// One producer (the pipeline's thread), one consumer (the publisher's). The producer never waits, never allocates and
/// makes no system call, whatever the consumer does: of frames and health the newest wins; final poses, which come only
/// once, have a queue of their own (`trajectory_queue`), and what it does not hold is counted.
class KINETRACE_API ResultMailbox {
 public:
  [[nodiscard]] static std::size_t required_bytes(const PublishConfig& config);
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<ResultMailbox>> create(const PublishConfig& config, Arena& arena);

  // Producer.

  /// Copies what is to be published. `handed_over_ns` is the system clock (Unix), `exposed_ns` the steady clock at
  /// mid-exposure, 0 where that is not known. At most 50 us for 64 objects and 2000 points.
  void offer(const FrameResult& result, std::int64_t handed_over_ns, std::int64_t exposed_ns = 0) noexcept;
  /// Of a result that comes only with a finalised frame (Pipeline::drain).
  void offer_finalised(const FrameResult& result) noexcept;
  void offer_health(const PublishedHealth& health) noexcept;
  /// No more results will come: every trajectory that is still open ends.
  void end_trajectories() noexcept;

  // Consumer. Valid until the next call that returns one; null if nothing is new.
  [[nodiscard]] const PublishedFrame* fetch_frame() noexcept { return frames_.fetch(); }
  [[nodiscard]] const PublishedHealth* fetch_health() noexcept { return health_.fetch(); }
  [[nodiscard]] bool fetch(TrajectoryEvent& event) noexcept { return events_.pop(event); }

  /// From any thread.
  [[nodiscard]] MailboxCounters counters() const noexcept;

 private:
  // A trajectory that has poses and has not ended.
  struct OpenTrajectory {
    std::uint32_t track_id = 0;
    std::uint16_t class_id = 0;
    std::int64_t last_alive_frame = 0;  ///< Newest frame in which its body was there.
  };

  ResultMailbox(const PublishConfig& config, Arena& arena);
  void offer_poses(const FrameEstimate& finalised) noexcept;
  void end_where_gone(const FrameResult& result) noexcept;
  void remember(const ObjectResult& object, std::int64_t frame) noexcept;
  void push(const TrajectoryEvent& event) noexcept;
  void push_end(const OpenTrajectory& open) noexcept;

  LatestValue<PublishedFrame> frames_;
  LatestValue<PublishedHealth> health_;
  EventQueue<TrajectoryEvent> events_;
  FixedVector<OpenTrajectory> open_;
  // Written by the producer alone; relaxed, since they order nothing.
  std::atomic<std::uint64_t> offered_ = 0;
  std::atomic<std::uint64_t> superseded_ = 0;
  std::atomic<std::uint64_t> poses_dropped_ = 0;
};

}  // namespace kinetrace::publishing
