// Errors for frequent failures: the message is stored in place, so that an error takes no memory.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "kinetrace/core/result.hpp"

namespace kinetrace {

/// A number as a part of a message.
class NumberText {
 public:
  template <std::integral Number>
  explicit NumberText(Number number) noexcept {
    char* const begin = digits_.data();
    size_ = static_cast<std::size_t>(std::to_chars(begin, begin + digits_.size(), number).ptr - begin);
  }
  // NOLINTNEXTLINE(google-explicit-constructor): a message's parts are texts.
  [[nodiscard]] operator std::string_view() const noexcept { return {digits_.data(), size_}; }

 private:
  std::array<char, 20> digits_{};  // 2^64 - 1 and -2^63.
  std::size_t size_ = 0;
};

/// A message stored in place, truncated at its capacity.
class InPlaceText {
 public:
  static constexpr std::size_t kMaxBytes = 1023;

  void append(std::string_view text) noexcept { size_ += text.copy(text_.data() + size_, kMaxBytes - size_); }

  [[nodiscard]] const char* c_str() const noexcept { return text_.data(); }
  // NOLINTNEXTLINE(google-explicit-constructor): it is a text.
  [[nodiscard]] operator std::string_view() const noexcept { return {text_.data(), size_}; }

 private:
  std::size_t size_ = 0;
  std::array<char, kMaxBytes + 1> text_{};
};

/// An Error whose message is stored in place; converts to Error.
struct InPlaceError {
  /// "SUBJECT: PARTS". A message that is too long loses the beginning of the subject, since the end of a path says
  /// most.
  InPlaceError(ErrorCode reason, std::string_view subject, std::initializer_list<std::string_view> parts) noexcept
      : code(reason) {
    std::size_t parts_bytes = kSeparator.size();
    for (const std::string_view part : parts) {
      parts_bytes += part.size();
    }
    if (subject.size() + parts_bytes > InPlaceText::kMaxBytes) {
      message.append(kCut);
      const std::size_t taken_bytes = std::min(parts_bytes + kCut.size(), InPlaceText::kMaxBytes);
      const std::size_t kept_bytes = InPlaceText::kMaxBytes - taken_bytes;
      subject.remove_prefix(subject.size() - std::min(kept_bytes, subject.size()));
    }
    message.append(subject);
    message.append(kSeparator);
    for (const std::string_view part : parts) {
      message.append(part);
    }
  }
  // NOLINTNEXTLINE(google-explicit-constructor): the same error in another place.
  [[nodiscard]] operator Error() const { return {code, std::string(message)}; }

  ErrorCode code;
  InPlaceText message;

 private:
  static constexpr std::string_view kSeparator = ": ";
  static constexpr std::string_view kCut = "...";
};

/// A T, or an error that took no memory. Converts to Result<T>.
template <typename T>
class [[nodiscard]] InPlaceResult : public Expected<T, InPlaceError> {
 public:
  using Expected<T, InPlaceError>::Expected;
  // NOLINTNEXTLINE(google-explicit-constructor): the same outcome in another place.
  [[nodiscard]] operator Result<T>() && {
    return this->has_value() ? Result<T>(*std::move(*this)) : Result<T>(Unexpected<Error>(this->error()));
  }
};

/// Success, or why not.
template <>
class [[nodiscard]] InPlaceResult<void> : public Expected<void, InPlaceError> {
 public:
  using Expected<void, InPlaceError>::Expected;
  // NOLINTNEXTLINE(google-explicit-constructor): the same outcome in another place.
  [[nodiscard]] operator Status() && { return has_value() ? Status() : Status(Unexpected<Error>(error())); }
};
using InPlaceStatus = InPlaceResult<void>;

}  // namespace kinetrace
