#include "kinetrace/features/appearance_memory.hpp"

#include <algorithm>
#include <span>

#include "appearance_entry.hpp"

namespace kinetrace::features {

AppearanceMemory::AppearanceMemory(std::size_t capacity, Arena& arena) {
  const std::span<Entry> entries = arena.take<Entry>(capacity);
  entries_ = entries.data();
  capacity_ = entries.size();
}

AppearanceMemory::Entry* AppearanceMemory::place_for(std::uint32_t feature_id) noexcept {
  const std::span<Entry> known(entries_, size_);
  const auto same =
      std::find_if(known.begin(), known.end(), [&](const Entry& entry) { return entry.feature_id == feature_id; });
  if (same != known.end()) {
    return &*same;
  }
  if (size_ < capacity_) {
    return &entries_[size_++];
  }
  const auto oldest =
      std::min_element(known.begin(), known.end(), [](const Entry& a, const Entry& b) { return a.note < b.note; });
  return oldest != known.end() && oldest->note != notes_ ? &*oldest : nullptr;
}

const Eigen::Vector3f& AppearanceMemory::p_body(std::size_t i) const noexcept {
  return entries_[i].p_body;
}

}  // namespace kinetrace::features
