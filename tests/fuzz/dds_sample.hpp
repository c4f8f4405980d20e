// Messages as the DDS library decodes them: any numbers, terminated strings, valid booleans.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fuzzer/FuzzedDataProvider.h>
#include <type_traits>
#include <vector>

namespace kinetrace::fuzz {

/// A message, or a part of one, from an input's bytes; the caller sets its booleans and sequences.
template <typename Message>
[[nodiscard]] Message any_message(FuzzedDataProvider& values) {
  static_assert(std::is_trivially_copyable_v<Message>);
  Message message{};
  values.ConsumeData(&message, sizeof(Message));
  return message;
}

template <std::size_t kSize>
void end_text(char (&text)[kSize]) {
  text[kSize - 1] = '\0';
}

/// `items` must outlive the sequence.
template <typename Sequence, typename Item>
void show(Sequence& sequence, std::vector<Item>& items) {
  sequence = {};
  sequence._buffer = items.data();
  sequence._length = static_cast<std::uint32_t>(items.size());
  sequence._maximum = sequence._length;
}

}  // namespace kinetrace::fuzz
