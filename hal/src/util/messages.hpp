// Small pieces of error messages.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

namespace kinetrace::hal {

template <typename... Parts>
[[nodiscard]] std::string concat(const Parts&... parts) {
  std::string text;
  (text.append(std::string_view(parts)), ...);
  return text;
}

/// Shortest form with up to six digits: "0.54", "nan".
[[nodiscard]] inline std::string number(double value) {
  if (std::isnan(value)) {
    return "nan";  // Its sign has no meaning.
  }
  std::array<char, 32> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6).ptr;
  return {buffer.data(), end};
}

[[nodiscard]] inline std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

/// "a, b, c", at most `limit` names, then "and N more".
template <typename Names>
[[nodiscard]] std::string listed(const Names& names, std::size_t limit = 8) {
  std::string text;
  std::size_t count = 0;
  for (const auto& name : names) {
    if (count++ == limit) {
      return text + " and " + std::to_string(names.size() - limit) + " more";
    }
    text.append(text.empty() ? "" : ", ").append(name);
  }
  return text;
}

}  // namespace kinetrace::hal
