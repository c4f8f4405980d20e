#include "cli/progress.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <unistd.h>

namespace kinetrace::app {
namespace {

constexpr std::chrono::milliseconds kRedrawInterval(100);
constexpr std::string_view kFull = "########################";
constexpr std::string_view kEmpty = "........................";

std::string_view environment(const char* name) noexcept {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

}  // namespace

bool stderr_is_terminal() noexcept {
  return isatty(STDERR_FILENO) == 1 && environment("TERM") != "dumb";
}

bool stderr_has_color() noexcept {
  return stderr_is_terminal() && environment("NO_COLOR").empty();
}

RedrawnLine::RedrawnLine(bool enabled) : enabled_(enabled && stderr_is_terminal()) {}

bool RedrawnLine::is_due() {
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now < next_) {
    return false;
  }
  next_ = now + kRedrawInterval;
  visible_ = true;
  return true;
}

void RedrawnLine::clear() {
  if (visible_) {
    std::fputs("\r\033[K", stderr);
    visible_ = false;
  }
}

Progress::Progress(bool enabled, std::optional<std::int64_t> frames_expected)
    : line_(enabled), frames_expected_(frames_expected) {}

void Progress::show(std::int64_t frames_done, int objects) {
  if (!line_.is_due()) {
    return;
  }
  const double seconds = line_.elapsed_s();
  const double rate_hz = seconds > 0.0 ? static_cast<double>(frames_done) / seconds : 0.0;
  std::array<char, 160> line{};
  if (frames_expected_ && *frames_expected_ > 0) {
    const auto width = static_cast<std::int64_t>(kFull.size());
    const int full = static_cast<int>(std::clamp<std::int64_t>(frames_done * width / *frames_expected_, 0, width));
    std::snprintf(line.data(), line.size(), "\r[%.*s%.*s] %lld/%lld frames, %.0f/s, objects: %d \033[K", full,
                  kFull.data(), static_cast<int>(width) - full, kEmpty.data(), static_cast<long long>(frames_done),
                  static_cast<long long>(*frames_expected_), rate_hz, objects);
  } else {
    std::snprintf(line.data(), line.size(), "\r%lld frames, %.0f/s, objects: %d \033[K",
                  static_cast<long long>(frames_done), rate_hz, objects);
  }
  std::fputs(line.data(), stderr);
}

}  // namespace kinetrace::app
