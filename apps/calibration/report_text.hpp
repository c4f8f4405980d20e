// Common parts of both calibration reports.
#pragma once

#include <array>
#include <cstdarg>
#include <cstdio>
#include <numbers>
#include <string>

namespace kinetrace::calibration {

inline constexpr double kDegrees = 180.0 / std::numbers::pi;

/// As printf has it; at most 255 characters.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] inline std::string text(const char* format, ...) {
  std::array<char, 256> buffer{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer.data(), buffer.size(), format, arguments);
  va_end(arguments);
  return buffer.data();
}

}  // namespace kinetrace::calibration
