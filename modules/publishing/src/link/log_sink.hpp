// Warnings and errors of the DDS library, at a rate that a user can read.
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

/// The library calls from threads of its own, so this is the one place of the module with a lock; the pipeline's thread
/// never comes here. There is one sink in a process. Lines are kept until fetched, `kKept` at most.
class LogSink {
 public:
  static constexpr std::size_t kKept = 8;

  /// Errors: kIllegalState while there is another one.
  [[nodiscard]] static Result<std::unique_ptr<LogSink>> create(int lines_per_minute);
  LogSink(const LogSink&) = delete;
  LogSink& operator=(const LogSink&) = delete;
  ~LogSink();

  /// What the library says, as it calls us.
  void add(const char* line, std::size_t size) noexcept;
  /// Renews the allowance; called now and then. `now_ns` is a steady clock.
  void tick(std::int64_t now_ns) noexcept;
  /// The next line that may be shown.
  [[nodiscard]] std::optional<std::string> take();
  /// The newest line, whether it may be shown or not: why a call of the library failed. It is forgotten with this.
  [[nodiscard]] std::string take_reason();

  [[nodiscard]] std::uint64_t lines() const noexcept { return lines_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t suppressed() const noexcept { return suppressed_.load(std::memory_order_relaxed); }

 private:
  using Line = std::array<char, 256>;  // Longer ones are cut.
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
