#include "cli/printable.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace kinetrace::app {
namespace {

constexpr char32_t kDelete = 0x7F;
constexpr char32_t kFirstShown = 0x20;
constexpr char32_t kFirstShownAfterDelete = 0xA0;

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  ///< 0: not UTF-8.
};

/// Properties of a first byte: number of bytes that follow, its bits of the code point, and the smallest code point of
/// this length.
struct Form {
  std::uint8_t mask;
  std::uint8_t bits;
  std::size_t following;
  char32_t least;
};
constexpr std::array<Form, 4> kForms{
    {{0x80, 0x00, 0, 0}, {0xE0, 0xC0, 1, 0x80}, {0xF0, 0xE0, 2, 0x800}, {0xF8, 0xF0, 3, 0x10000}}};

Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  for (const Form& form : kForms) {
    if ((byte(0) & form.mask) != form.bits) {
      continue;
    }
    if (form.following >= text.size()) {
      return {};
    }
    char32_t code = byte(0) & static_cast<std::uint8_t>(~form.mask);
    for (std::size_t i = 1; i <= form.following; ++i) {
      if ((byte(i) & 0xC0U) != 0x80U) {
        return {};
      }
      code = (code << 6U) | (byte(i) & 0x3FU);
    }
    const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
    return code < form.least || is_surrogate || code > 0x10FFFF ? Character{} : Character{code, form.following + 1};
  }
  return {};
}

bool is_shown(const Character& character) {
  const char32_t code = character.code;
  return character.bytes > 0 && code >= kFirstShown && (code < kDelete || code >= kFirstShownAfterDelete);
}

void append_escaped(char byte, std::string& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto value = static_cast<std::uint8_t>(byte);
  out += "\\x";
  out += kDigits[value >> 4U];
  out += kDigits[value & 0xFU];
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character character = first_character(text);
    const std::size_t bytes = character.bytes > 0 ? character.bytes : 1;
    if (is_shown(character)) {
      out += text.substr(0, bytes);
    } else {
      for (const char byte : text.substr(0, bytes)) {
        append_escaped(byte, out);
      }
    }
    text.remove_prefix(bytes);
  }
  return out;
}

}  // namespace kinetrace::app
