#include "kinetrace/core/nearest_name.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace kinetrace {
namespace {

// Levenshtein's edit distance in which exchanging two neighbours is one edit (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> names) {
  std::optional<std::string_view> nearest;
  // Fewer edits than letters: a name that shares no letter is no suggestion.
  std::size_t bound = std::min(std::max<std::size_t>(2, word.size() / 4) + 1, word.size());
  for (const std::string_view name : names) {
    const std::size_t fewest_edits = std::max(word.size(), name.size()) - std::min(word.size(), name.size());
    if (fewest_edits >= bound) {
      continue;
    }
    if (const std::size_t distance = edit_distance(word, name); distance < bound) {
      bound = distance;
      nearest = name;
    }
  }
  return nearest;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> names) {
  const std::optional<std::string_view> nearest = nearest_name(word, names);
  return nearest ? "; did you mean " + std::string(*nearest) + "?" : std::string();
}

}  // namespace kinetrace
