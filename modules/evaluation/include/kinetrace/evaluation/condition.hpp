// Conditions on an evaluation, such as "camera.t_rel>1.0".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"

namespace kinetrace::evaluation {

struct Condition {
  enum class Comparison : std::uint8_t { kGreater, kGreaterOrEqual, kLess, kLessOrEqual, kEqual };
  std::string text;  ///< As given.
  std::string path;  ///< Names joined by dots; a number is the place in a list.
  Comparison comparison = Comparison::kGreater;
  double bound = 0.0;
};

/// Parses `PATH OP NUMBER`, OP one of > >= < <= ==; blanks are ignored. Errors: kInvalidArgument.
[[nodiscard]] Result<Condition> parse_condition(std::string_view text);

/// Result of a condition on an evaluation.
struct ConditionOutcome {
  bool holds = false;
  double value = 0.0;
};

/// `json` is from evaluation_json. Errors: kInvalidArgument (no such path, or no number there), kBadFormat (the value
/// could not be measured).
[[nodiscard]] Result<ConditionOutcome> check(const Condition& condition, std::string_view json);

}  // namespace kinetrace::evaluation
