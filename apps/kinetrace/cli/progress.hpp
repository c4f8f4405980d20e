// Progress line on a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace kinetrace::app {

/// Redraws one line on standard error a few times a second; silent if that is no terminal. Never allocates.
class Progress {
 public:
  /// `frames_expected`: none for an endless source.
  Progress(bool enabled, std::optional<std::int64_t> frames_expected);

  void show(std::int64_t frames_done, int objects);
  /// Removes the line, so that other text can follow.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool visible_ = false;
  std::optional<std::int64_t> frames_expected_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

/// True if standard error is a terminal that can redraw a line.
[[nodiscard]] bool stderr_is_terminal() noexcept;
/// The same, unless the user asked for plain text (https://no-color.org).
[[nodiscard]] bool stderr_has_color() noexcept;

}  // namespace kinetrace::app
