// Rate-limited warnings and errors of the DDS library.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"

namespace kinetrace::publishing {

/// The library calls from its own threads, so this class locks; the pipeline's thread never uses it. One sink per
/// process. Keeps at most `kKept` lines until fetched.
class LogSink {
 public:
  static constexpr std::size_t kKept = 8;

  /// Errors: kIllegalState (another sink exists).
  [[nodiscard]] static Result<std::unique_ptr<LogSink>> create(int lines_per_minute);
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;
  ~LogSink();

  /// Callback of the library.
  void add(const char* line, std::size_t size) noexcept;
  /// Renews the allowance; called periodically. `now_ns` is a steady clock.
  void tick(std::int64_t now_ns) noexcept;
  /// The next line within the allowance.
  [[nodiscard]] std::optional<std::string> take();
  /// Takes the newest line, regardless of the allowance: the reason of a failed call of the library.
  [[nodiscard]] std::string take_reason();

  [[nodiscard]] std::uint64_t lines() const noexcept { return lines_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t suppressed() const noexcept { return suppressed_.load(std::memory_order_relaxed); }

 private:
  using Line = std::array<char, 256>;  // Longer lines are truncated.
  explicit LogSink(int lines_per_minute) : lines_per_minute_(lines_per_minute), allowance_(lines_per_minute) {}

  const int lines_per_minute_;
  std::atomic<std::uint64_t> lines_ = 0;
  std::atomic<std::uint64_t> suppressed_ = 0;
  std::mutex mutex_;
  std::array<Line, kKept> kept_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  Line newest_{};
  int allowance_;
  std::int64_t minute_began_ns_ = 0;
};

}  // namespace kinetrace::publishing
