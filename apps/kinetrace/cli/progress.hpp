// Lines on a terminal that are redrawn.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace kinetrace::app {

/// A line on standard error that is redrawn a few times a second; none if that is no terminal.
class RedrawnLine {
 public:
  explicit RedrawnLine(bool enabled);

  /// Time to draw it; it then counts as drawn.
  [[nodiscard]] bool is_due();
  /// Since the line exists.
  [[nodiscard]] double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// Removes the line, so that other text can follow.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool visible_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

/// Frames done and their rate. Never allocates.
class Progress {
 public:
  /// `frames_expected`: none for an endless source.
  Progress(bool enabled, std::optional<std::int64_t> frames_expected);

  void show(std::int64_t frames_done, int objects);
  void clear() { line_.clear(); }

 private:
  RedrawnLine line_;
  std::optional<std::int64_t> frames_expected_;
};

/// True if standard error is a terminal that can redraw a line.
[[nodiscard]] bool stderr_is_terminal() noexcept;
/// The same, unless the user asked for plain text (https://no-color.org).
[[nodiscard]] bool stderr_has_color() noexcept;

}  // namespace kinetrace::app
