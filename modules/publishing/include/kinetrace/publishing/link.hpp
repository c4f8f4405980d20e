// The membership in a DDS domain, looked after.
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
  kWaiting,    ///< The interface is not there, or has no address: nothing is sent or received.
  kConnected,  ///< There is a participant; others come and go as they like.
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

/// What writers and readers are made in: handles of the DDS library. With another number everything that was made
/// before is gone.
struct LinkMembership {
  std::uint64_t number = 0;  ///< 0: there is no participant.
  std::int32_t participant = 0;
};

/// Holds the participant and looks after it: it is made when the interface has an address, and made anew when the
/// interface goes and returns or its address changes, which DDS libraries do not survive by themselves.
///
/// The DDS library's log is a global of the process, so there is one Link at a time, for all that writes and reads.
/// The environment (CYCLONEDDS_URI) is not looked at.
class KINETRACE_API Link {
 public:
  /// How often the interface is looked at, and how often a participant that failed is tried again.
  static constexpr std::int64_t kLookEvery_ns = 500'000'000;
  static constexpr std::int64_t kRetryEvery_ns = 5'000'000'000;

  /// Checks everything that can be checked before there is a network, and connects if the interface is there.
  /// Errors: kInvalidConfig (also: security files that do not fit together, own XML that the library refuses),
  /// kNotFound, kIo (a file), kIllegalState (a second Link).
  [[nodiscard]] static Result<std::unique_ptr<Link>> create(const PublishConfig& config);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  /// After everything that was made in it.
  ~Link();

  /// Everything that is due; called again and again by one thread. `now_ns` is a steady clock.
  void supervise(std::int64_t now_ns);
  /// What the user should hear: a change of the link, a line of the DDS library. None if there is nothing new. By the
  /// thread that supervises.
  [[nodiscard]] std::optional<std::string> take_notice();

  // From any thread.

  /// An error of the DDS library about something in this link; names the file of the configuration that is to blame.
  [[nodiscard]] Error explained(const Error& error) const;

  /// Returns when a reader made in this link has something to be taken, after `wake()`, or when the time is over.
  void wait(std::int64_t at_most_ns) noexcept;
  void wake() noexcept;
  [[nodiscard]] LinkMembership membership() const noexcept;
  /// A handle of the DDS library that readers attach to, so that `wait` notices them.
  [[nodiscard]] std::int32_t waitset() const noexcept;
  [[nodiscard]] LinkState state() const noexcept;
  /// Other participants of the domain that have been seen; also those that security will refuse.
  [[nodiscard]] std::size_t others() const;
  /// Participants made after the first one.
  [[nodiscard]] std::uint64_t restarts() const noexcept;
  /// Warnings and errors of the DDS library, and those beyond log_lines_per_minute.
  [[nodiscard]] std::uint64_t log_lines() const noexcept;
  [[nodiscard]] std::uint64_t log_lines_suppressed() const noexcept;

 private:
  struct Impl;
  explicit Link(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing
