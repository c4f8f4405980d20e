#include "kinetrace/core/arena.hpp"

#include <cstring>

namespace kinetrace {

Arena::Arena(std::size_t capacity_bytes)
    : block_(static_cast<std::byte*>(
          ::operator new (capacity_bytes == 0 ? 1 : capacity_bytes, std::align_val_t{kAlignment}))),
      capacity_bytes_(capacity_bytes) {
  std::memset(block_.get(), 0, capacity_bytes);
}

std::byte* Arena::reserve(std::size_t bytes) noexcept {
  const std::size_t rounded_bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (measuring()) {
    used_bytes_ += rounded_bytes;
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
