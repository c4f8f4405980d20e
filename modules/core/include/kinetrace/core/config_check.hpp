// Range checks of configuration values and their error message.
#pragma once

#include <initializer_list>
#include <sstream>
#include <string_view>

#include "kinetrace/core/result.hpp"

namespace kinetrace {

/// kInvalidConfig naming the key, unless low <= value <= high; NaN is out of range.
template <typename T>
[[nodiscard]] Status check_range(std::string_view key, T value, T low, T high) {
  if (value >= low && value <= high) {
    return {};
  }
  std::ostringstream message;
  message << key << " must be in [" << low << ", " << high << "], got " << value;
  return fail(ErrorCode::kInvalidConfig, message.str());
}

/// The first failure, or success.
[[nodiscard]] inline Status first_failure(std::initializer_list<Status> statuses) {
  for (const Status& status : statuses) {
    if (!status) {
      return status;
    }
  }
  return {};
}

}  // namespace kinetrace
