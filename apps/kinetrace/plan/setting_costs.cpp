#include "plan/setting_costs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

namespace kinetrace::app {
namespace {

// Smaller differences are artefacts of alignment: parts begin at multiples of 64 bytes.
constexpr double kRounding_bytes = 16.0;

// Total with `value` in `place`; none if invalid.
template <typename Value>
std::optional<double> total_with(Value& place, Value value, const std::function<Result<double>()>& total_bytes) {
  const Value before = std::exchange(place, value);
  const Result<double> total = total_bytes();
  place = before;
  return total ? std::optional<double>(*total) : std::nullopt;
}

std::optional<double> cost_of_one(int& place, double now_bytes, const std::function<Result<double>()>& total_bytes) {
  // A step of an eighth: finer steps would vanish in the rounding.
  const int step = std::max(1, std::abs(place) / 8);
  for (const int change : {step, -step}) {
    if (const auto total = total_with(place, place + change, total_bytes)) {
      return (*total - now_bytes) / change;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<SettingCost> setting_costs(const ConfigFields& fields, const std::function<Result<double>()>& total_bytes) {
  std::vector<SettingCost> costs;
  const Result<double> now_bytes = total_bytes();
  if (!now_bytes) {
    return costs;
  }
  for (const ConfigField& field : fields) {
    std::optional<double> bytes;
    double count = 1.0;
    if (int* const* number = std::get_if<int*>(&field.value)) {
      bytes = cost_of_one(**number, *now_bytes, total_bytes);
      count = **number;
    } else if (bool* const* is_on = std::get_if<bool*>(&field.value)) {
      const auto other = total_with(**is_on, !**is_on, total_bytes);
      bytes = other ? std::optional<double>(std::abs(*other - *now_bytes)) : std::nullopt;
      count = **is_on ? 1.0 : 0.0;
    }
    if (bytes && *bytes >= kRounding_bytes) {
      costs.push_back({field.key, value_text(field), *bytes, *bytes * count});
    }
  }
  std::stable_sort(costs.begin(), costs.end(),
                   [](const SettingCost& a, const SettingCost& b) { return a.share_bytes > b.share_bytes; });
  return costs;
}

}  // namespace kinetrace::app
