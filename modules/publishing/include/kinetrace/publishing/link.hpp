// Supervised membership in a DDS domain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

enum class LinkState : std::uint8_t {
  kWaiting,    ///< The interface is missing or has no address: nothing is sent or received.
  kConnected,  ///< There is a participant, with or without peers.
  kFailed,     ///< The interface exists, but the DDS library refuses; retried every few seconds.
};

[[nodiscard]] constexpr std::string_view to_string(LinkState state) noexcept {
  switch (state) {
    case LinkState::kWaiting: return "waiting";
    case LinkState::kConnected: return "connected";
    case LinkState::kFailed: return "failed";
  }
  return "failed";
}

/// Handle of the participant that writers and readers belong to. A change of `number` invalidates all of them.
struct LinkMembership {
  std::uint64_t number = 0;  ///< 0: no participant.
  std::int32_t participant = 0;
};

/// Owns and supervises the participant: creates it when the interface has an address, and again when the interface
/// returns or its address changes, which DDS libraries do not handle by themselves.
///
/// The DDS library's log is global to the process, so there is at most one Link, shared by all writers and readers. The
/// environment (CYCLONEDDS_URI) is ignored.
class KINETRACE_API Link {
 public:
  /// Intervals of checking the interface and of retrying a failed participant.
  static constexpr std::int64_t kLookEvery_ns = 500'000'000;
  static constexpr std::int64_t kRetryEvery_ns = 5'000'000'000;

  /// Checks everything that does not need a network, and connects if the interface exists. Errors: kInvalidConfig
  /// (also: security files that do not fit together, own XML that the library refuses), kNotFound, kIo (a file),
  /// kIllegalState (a second Link).
  [[nodiscard]] static Result<std::unique_ptr<Link>> create(const PublishConfig& config);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  /// Destroy after all its readers and writers.
  ~Link();

  /// Does the periodic work; called repeatedly by one thread. `now_ns` is a steady clock.
  void supervise(std::int64_t now_ns);
  /// The next notice for the user: a change of the link, a line of the DDS library; none if there is nothing new. For
  /// the supervising thread.
  [[nodiscard]] std::optional<std::string> take_notice();

  // Thread-safe:

  /// Explains an error of the DDS library: adds the responsible configuration file.
  [[nodiscard]] Error explained(const Error& error) const;

  /// Returns when a reader of this link has data, after `wake()`, or at the time-out.
  void wait(std::int64_t at_most_ns) noexcept;
  void wake() noexcept;
  [[nodiscard]] LinkMembership membership() const noexcept;
  /// The DDS waitset that readers attach to, so that their data ends `wait`.
  [[nodiscard]] std::int32_t waitset() const noexcept;
  [[nodiscard]] LinkState state() const noexcept;
  /// Number of other discovered participants, including those that security will refuse.
  [[nodiscard]] std::size_t others() const;
  /// Number of participants created after the first.
  [[nodiscard]] std::uint64_t restarts() const noexcept;
  /// Number of warnings and errors of the DDS library, and of those beyond log_lines_per_minute.
  [[nodiscard]] std::uint64_t log_lines() const noexcept;
  [[nodiscard]] std::uint64_t log_lines_suppressed() const noexcept;

 private:
  struct Impl;
  explicit Link(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing
