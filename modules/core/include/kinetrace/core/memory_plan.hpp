// Shares of the working memory by module.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kinetrace {

struct MemoryPlanEntry {
  std::string name;
  std::size_t bytes = 0;
  std::string depends_on;  ///< The configuration keys that decide the size.
};

/// Made before start; `total_bytes()` is the arena's size.
struct MemoryPlan {
  std::vector<MemoryPlanEntry> entries;
  [[nodiscard]] std::size_t total_bytes() const {
    std::size_t sum = 0;
    for (const MemoryPlanEntry& entry : entries) {
      sum += entry.bytes;
    }
    return sum;
  }
};

}  // namespace kinetrace
