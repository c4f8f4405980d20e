#include "kinetrace/core/arena.hpp"

#include <cstring>
#include <limits>

namespace kinetrace {

Arena::Arena(std::size_t capacity_bytes)
    : block_(static_cast<std::byte*>(
          ::operator new (capacity_bytes == 0 ? 1 : capacity_bytes, std::align_val_t{kAlignment}))),
      capacity_bytes_(capacity_bytes) {
  std::memset(block_.get(), 0, capacity_bytes);
}

std::byte* Arena::reserve(std::size_t count, std::size_t element_bytes) noexcept {
  // A count that overflows (a negative setting turned unsigned) must not wrap to a small request.
  constexpr std::size_t kMax = std::numeric_limits<std::size_t>::max() / kAlignment * kAlignment;
  const bool too_large = count > (kMax - kAlignment) / element_bytes;
  const std::size_t rounded_bytes =
      too_large ? kMax : (count * element_bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (measuring()) {
    used_bytes_ = rounded_bytes > kMax - used_bytes_ ? kMax : used_bytes_ + rounded_bytes;
    return nullptr;
  }
  if (rounded_bytes > capacity_bytes_ - used_bytes_) {
    exhausted_ = true;
    return nullptr;
  }
  std::byte* memory = block_.get() + used_bytes_;
  used_bytes_ += rounded_bytes;
  return memory;
}

}  // namespace kinetrace
