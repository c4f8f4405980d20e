// A condition of --fail-if, and the evaluation.json that it is checked against.
#include "kinetrace/evaluation/condition.hpp"

#include "fuzz_target.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  const auto parts = parts_of(input, 2);
  if (const auto condition = evaluation::parse_condition(parts[0])) {
    static_cast<void>(evaluation::check(*condition, parts[1]));
  }
}
