// Passes results from the pipeline's thread to the publisher's.
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

/// Running totals of the mailbox.
struct MailboxCounters {
  std::uint64_t offered = 0;     ///< Frames.
  std::uint64_t superseded = 0;  ///< Of these, replaced by a newer one before the publisher fetched them.
  std::uint64_t trajectory_poses_dropped = 0;
};

/// One producer (the pipeline's thread), one consumer (the publisher's). The producer never blocks, never allocates and
/// makes no system call: of frames and health the newest wins; final poses, which are offered only once, have a queue
/// (`trajectory_queue`), which drops and counts the excess.
class KINETRACE_API ResultMailbox {
 public:
  [[nodiscard]] static std::size_t required_bytes(const PublishConfig& config);
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<ResultMailbox>> create(const PublishConfig& config, Arena& arena);

  // Producer.

  /// Copies the data to publish. `handed_over_ns` is the system clock (Unix), `exposed_ns` the steady clock at
  /// mid-exposure; 0: unknown. At most 50 us for 64 objects and 2000 points.
  void offer(const FrameResult& result, std::int64_t handed_over_ns, std::int64_t exposed_ns = 0) noexcept;
  /// For a result with a finalised frame only (Pipeline::drain).
  void offer_finalised(const FrameResult& result) noexcept;
  void offer_health(const PublishedHealth& health) noexcept;
  /// Ends every open trajectory; call after the last result.
  void end_trajectories() noexcept;

  // Consumer. Results are valid until the next one is returned; null: nothing new.
  [[nodiscard]] const PublishedFrame* fetch_frame() noexcept { return frames_.fetch(); }
  [[nodiscard]] const PublishedHealth* fetch_health() noexcept { return health_.fetch(); }
  [[nodiscard]] bool fetch(TrajectoryEvent& event) noexcept { return events_.pop(event); }

  /// Thread-safe.
  [[nodiscard]] MailboxCounters counters() const noexcept;

 private:
  // A trajectory with poses that has not ended.
  struct OpenTrajectory {
    std::uint32_t track_id = 0;
    std::uint16_t class_id = 0;
    std::int64_t last_alive_frame = 0;  ///< Newest frame with its body.
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
