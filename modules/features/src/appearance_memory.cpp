#include "kinetrace/features/appearance_memory.hpp"

#include "appearance_entry.hpp"

namespace kinetrace::features {

AppearanceMemory::AppearanceMemory(std::size_t capacity, Arena& arena) {
  const std::span<Entry> entries = arena.take<Entry>(capacity);
  entries_ = entries.data();
  capacity_ = entries.size();
}

const Eigen::Vector3f& AppearanceMemory::p_body(std::size_t i) const noexcept {
  return entries_[i].p_body;
}

}  // namespace kinetrace::features
