// Results out into the network, as DDS topics.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/publish_config.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "kinetrace/publishing/result_mailbox.hpp"

namespace kinetrace::publishing {

enum class LinkState : std::uint8_t {
  kWaiting,    ///< The interface is not there, or has no address: nothing is sent.
  kConnected,  ///< There is a participant; readers come and go as they like.
  kFailed,     ///< The interface is there, but the DDS library refuses; tried again every few seconds.
};

[[nodiscard]] constexpr std::string_view to_string(LinkState state) noexcept {
  switch (state) {
    case LinkState::kWaiting: return "waiting";
    case LinkState::kConnected: return "connected";
    case LinkState::kFailed: return "failed";
  }
  return "failed";
}

/// Running totals. A message for several readers counts once, its bytes once for each.
struct PublishCounters {
  std::uint64_t frames = 0;                ///< Fetched from the mailbox.
  std::uint64_t frames_without_link = 0;   ///< Of these, not sent for lack of a participant.
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
/// All of PublishCounters, by the names under which users see them.
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

/// Owns the participant and everything that writes. All calls but `state` and `counters` come from one thread, which
/// the application owns. Writing may take as long as the network likes (a saturated link has been seen to hold a write
/// for 0.4 s); that is why the pipeline's thread never calls this.
///
/// The participant is supervised: made when the interface has an address, and made anew when the interface goes and
/// returns or its address changes, which DDS libraries do not survive by themselves.
///
/// The DDS library's log is a global of the process, so there is one Publisher at a time. The environment
/// (CYCLONEDDS_URI) is not looked at.
class Publisher {
 public:
  /// How often the interface is looked at, and how often a participant that failed is tried again.
  static constexpr std::int64_t kLookEvery_ns = 500'000'000;
  static constexpr std::int64_t kRetryEvery_ns = 5'000'000'000;
  static constexpr std::int64_t kHealthEvery_ns = 1'000'000'000;

  /// From the arena: buffers of messages. The DDS library allocates by itself: see participant_bytes.
  [[nodiscard]] static std::size_t required_bytes(const PublishConfig& config);
  /// What a participant adds to the resident memory, as measured with 64 objects and 2000 points at 30 Hz.
  [[nodiscard]] static std::size_t participant_bytes() noexcept;

  /// Checks everything that can be checked before there is a network, and connects if the interface is there.
  /// Errors: kInvalidConfig (also: security files that do not fit together, own XML that the library refuses),
  /// kNotFound, kIo (a file), kCapacity, kIllegalState (a second Publisher).
  [[nodiscard]] static Result<std::unique_ptr<Publisher>> create(const PublishConfig& config,
                                                                 const StereoGeometry& geometry, Arena& arena);
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;
  ~Publisher();

  /// Everything that is due: looks after the participant, then sends what the mailbox has. `now_ns` is a steady clock.
  void serve(ResultMailbox& mailbox, std::int64_t now_ns);

  /// The parts of `serve`.
  void supervise(std::int64_t now_ns);
  void publish(const PublishedFrame& frame, std::int64_t now_ns);
  void publish(const PublishedHealth& health, std::int64_t now_ns);
  void publish(const TrajectoryEvent& event, std::int64_t now_ns);

  /// What the user should hear: a change of the link, a line of the DDS library. None if there is nothing new.
  [[nodiscard]] std::optional<std::string> take_notice();

  /// From any thread.
  [[nodiscard]] LinkState state() const noexcept;
  [[nodiscard]] PublishCounters counters() const noexcept;

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing
