// Text as printf has it.
#pragma once

#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace kinetrace::app {

/// At most 255 characters.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] inline std::string formatted(const char* format, ...) {
  std::array<char, 256> buffer{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer.data(), buffer.size(), format, arguments);
  va_end(arguments);
  return buffer.data();
}

}  // namespace kinetrace::app
