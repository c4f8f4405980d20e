// Fills the C structures of messages without copying their elements.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

namespace kinetrace::publishing {

/// Makes a message's sequence refer to `items`, which the caller keeps.
template <typename Sequence>
void set_items(Sequence& sequence, std::span<std::remove_pointer_t<decltype(Sequence::_buffer)>> items) noexcept {
  sequence._buffer = items.data();
  sequence._length = static_cast<std::uint32_t>(items.size());
  sequence._maximum = sequence._length;
  sequence._release = false;
}

/// Bounded strings are arrays; excess is truncated.
inline void copy_text(std::string_view text, std::span<char> out) noexcept {
  const std::size_t size = std::min(text.size(), out.size() - 1);
  std::copy_n(text.data(), size, out.begin());
  out[size] = '\0';
}

/// A piece of data too long for one message.
struct Piece {
  std::size_t first = 0;
  std::size_t count = 0;
  std::uint32_t index = 0;
  std::uint32_t of = 1;
};

/// Calls `send(piece)` for each piece; once with an empty piece if there are no items.
template <typename Send>
void in_pieces(std::size_t total, std::size_t per_piece, Send&& send) {
  const std::size_t pieces = std::max<std::size_t>(1, (total + per_piece - 1) / per_piece);
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::size_t first = i * per_piece;
    send(Piece{first, std::min(per_piece, total - first), static_cast<std::uint32_t>(i),
               static_cast<std::uint32_t>(pieces)});
  }
}

/// Number of items of `item_bytes` that fit into a piece beside the message's fixed part; at least one.
[[nodiscard]] constexpr std::size_t items_per_piece(int piece_bytes, std::size_t item_bytes,
                                                    std::size_t bound) noexcept {
  constexpr std::size_t kBeginningBytes = 256;
  const std::size_t room = static_cast<std::size_t>(piece_bytes) - kBeginningBytes;
  return std::clamp<std::size_t>(room / item_bytes, 1, bound);
}

}  // namespace kinetrace::publishing
