// Publishes results as DDS topics.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/link.hpp"
#include "kinetrace/publishing/publish_config.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "kinetrace/publishing/result_mailbox.hpp"

namespace kinetrace::publishing {

/// Running totals. A message for several readers counts once, its bytes once for each.
struct PublishCounters {
  std::uint64_t frames = 0;                ///< Fetched from the mailbox.
  std::uint64_t frames_without_link = 0;   ///< Of these: not sent for lack of a participant.
  std::uint64_t messages = 0;              ///< Written.
  std::uint64_t bytes = 0;                 ///< Of user data, estimated.
  std::uint64_t skipped_for_budget = 0;    ///< Messages that bytes_per_second did not allow.
  std::uint64_t write_errors = 0;          ///< Refused by the DDS library.
  std::uint64_t participant_restarts = 0;  ///< After the first one.
  std::uint64_t log_lines = 0;             ///< Warnings and errors of the DDS library ...
  std::uint64_t log_lines_suppressed = 0;  ///< ... and those beyond log_lines_per_minute.
};

struct PublishCounterName {
  std::string_view name;
  std::uint64_t PublishCounters::*member;
};
/// All of PublishCounters with their names for users.
inline constexpr std::array<PublishCounterName, 9> kPublishCounterNames{{
    {"dds_frames", &PublishCounters::frames},
    {"dds_frames_without_link", &PublishCounters::frames_without_link},
    {"dds_messages", &PublishCounters::messages},
    {"dds_bytes", &PublishCounters::bytes},
    {"dds_messages_over_budget", &PublishCounters::skipped_for_budget},
    {"dds_write_errors", &PublishCounters::write_errors},
    {"dds_participant_restarts", &PublishCounters::participant_restarts},
    {"dds_log_lines", &PublishCounters::log_lines},
    {"dds_log_lines_suppressed", &PublishCounters::log_lines_suppressed},
}};
static_assert(sizeof(PublishCounters) == kPublishCounterNames.size() * sizeof(std::uint64_t), "a counter has no name");

/// Owns the participant and all writers. All calls but `state` and `counters` come from one thread, owned by the
/// application. A write may block on the network (0.4 s observed on a saturated link); so the pipeline's thread never
/// calls this.
///
/// Owns and supervises the process's Link; other readers and writers in the same domain share it.
class KINETRACE_API Publisher {
 public:
  static constexpr std::int64_t kHealthEvery_ns = 1'000'000'000;

  /// Memory from the arena: message buffers. The DDS library allocates its own: see participant_bytes.
  [[nodiscard]] static std::size_t required_bytes(const PublishConfig& config);
  /// Resident memory of a participant: twice the value measured with 64 objects and 2000 points at 30 Hz.
  [[nodiscard]] static std::size_t participant_bytes(const PublishConfig& config) noexcept;

  /// Errors: as Link::create; kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<Publisher>> create(const PublishConfig& config,
                                                                 const StereoGeometry& geometry, Arena& arena);
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;
  ~Publisher();

  /// Does the periodic work: supervises the participant, then sends the contents of the mailbox. `now_ns` is a steady
  /// clock. Returns the frame that was sent, valid until the next call; null if there was none, or no network.
  const PublishedFrame* serve(ResultMailbox& mailbox, std::int64_t now_ns);

  /// The two parts of `serve`.
  void supervise(std::int64_t now_ns);
  void publish(const PublishedFrame& frame, std::int64_t now_ns);
  void publish(const PublishedHealth& health, std::int64_t now_ns);
  void publish(const TrajectoryEvent& event, std::int64_t now_ns);

  /// The next notice for the user: a change of the link, a line of the DDS library; none if there is nothing new.
  [[nodiscard]] std::optional<std::string> take_notice();

  /// Thread-safe.
  [[nodiscard]] LinkState state() const noexcept;
  [[nodiscard]] PublishCounters counters() const noexcept;
  /// For other readers and writers, which must not outlive the publisher.
  [[nodiscard]] Link& link() noexcept;

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing
