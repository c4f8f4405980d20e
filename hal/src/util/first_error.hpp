// Several Results at once.
#pragma once

#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// The error of the first result that failed, or null.
template <typename... Results>
[[nodiscard]] const Error* first_error(const Results&... results) {
  const Error* error = nullptr;
  const auto look = [&error](const auto& result) {
    if (error == nullptr && !result) {
      error = &result.error();
    }
  };
  (look(results), ...);
  return error;
}

}  // namespace kinetrace::hal
