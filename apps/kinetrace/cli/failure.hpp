// Failure of a command: message and exit code.
#pragma once

#include <string>
#include <utility>

#include "cli/exit_codes.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

struct Failure {
  ExitCode code = ExitCode::kInternal;
  std::string message;  ///< One line: the cause and the remedy.
};

template <typename T>
using Outcome = Expected<T, Failure>;

[[nodiscard]] inline Failure to_failure(Error error) {
  return {exit_code(error.code), std::move(error.message)};
}

/// `return failure(result.error())` from any function that returns an Outcome.
[[nodiscard]] inline Unexpected<Failure> failure(Error error) {
  return Unexpected(to_failure(std::move(error)));
}

}  // namespace kinetrace::app
