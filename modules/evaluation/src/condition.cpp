#include "kinetrace/evaluation/condition.hpp"

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "kinetrace/core/nearest_name.hpp"
#include "kinetrace/core/text_rows.hpp"

namespace kinetrace::evaluation {
namespace {

using Comparison = Condition::Comparison;

// Longer ones first: ">=" begins like ">".
constexpr std::array<std::pair<std::string_view, Comparison>, 5> kComparisons{{{">=", Comparison::kGreaterOrEqual},
                                                                               {"<=", Comparison::kLessOrEqual},
                                                                               {"==", Comparison::kEqual},
                                                                               {">", Comparison::kGreater},
                                                                               {"<", Comparison::kLess}}};

std::string without_blanks(std::string_view text) {
  std::string kept;
  for (const char character : text) {
    if (character != ' ' && character != '\t') {
      kept += character;
    }
  }
  return kept;
}

bool compare(double value, Comparison comparison, double bound) {
  switch (comparison) {
    case Comparison::kGreater: return value > bound;
    case Comparison::kGreaterOrEqual: return value >= bound;
    case Comparison::kLess: return value < bound;
    case Comparison::kLessOrEqual: return value <= bound;
    case Comparison::kEqual: return value == bound;
  }
  return false;
}

std::string names_like(const std::string& name, const nlohmann::json& place) {
  std::vector<std::string_view> names;
  for (const auto& [key, value] : place.items()) {
    names.emplace_back(key);
  }
  return did_you_mean(name, names);
}

// Null if it leads into a value that was not measured. Error: a name on the path does not exist.
Result<const nlohmann::json*> find(const nlohmann::json& root, std::string_view path) {
  const nlohmann::json* place = &root;
  while (!path.empty() && !place->is_null()) {
    const std::size_t length = std::min(path.find('.'), path.size());
    const std::string name(path.substr(0, length));
    path.remove_prefix(std::min(length + 1, path.size()));
    const std::optional<std::int64_t> index = parse_integer(name);
    if (place->is_object() && place->contains(name)) {
      place = &(*place)[name];
    } else if (place->is_array() && index && *index >= 0 && static_cast<std::size_t>(*index) < place->size()) {
      place = &(*place)[static_cast<std::size_t>(*index)];
    } else {
      return fail(ErrorCode::kInvalidArgument, "the evaluation has no '" + name + "' there" +
                                                   (place->is_object() ? names_like(name, *place) : "") +
                                                   "; its names are in evaluation.json");
    }
  }
  if (!place->is_number() && !place->is_null()) {
    return fail(ErrorCode::kInvalidArgument, "it names no number; those of numbers are in evaluation.json");
  }
  return place;
}

}  // namespace

Result<Condition> parse_condition(std::string_view text) {
  Condition condition;
  condition.text = text;
  const std::string compact = without_blanks(text);
  const std::size_t place = compact.find_first_of("<>=");
  for (const auto& [symbol, comparison] : kComparisons) {
    if (place == std::string::npos || place == 0 || compact.compare(place, symbol.size(), symbol) != 0) {
      continue;
    }
    condition.path = compact.substr(0, place);
    condition.comparison = comparison;
    const std::optional<double> bound = parse_number(std::string_view(compact).substr(place + symbol.size()));
    if (!bound) {
      break;
    }
    condition.bound = *bound;
    return condition;
  }
  return fail(ErrorCode::kInvalidArgument,
              "condition '" + condition.text + "': expected PATH>NUMBER (or >= < <= ==), such as camera.t_rel>1.0");
}

Result<ConditionOutcome> check(const Condition& condition, std::string_view json) {
  const nlohmann::json root = nlohmann::json::parse(json, nullptr, false);
  const Result<const nlohmann::json*> found = find(root, condition.path);
  if (!found) {
    return fail(found.error().code, "condition '" + condition.text + "': " + found.error().message);
  }
  const nlohmann::json* value = *found;
  if (value->is_null()) {
    return fail(ErrorCode::kBadFormat,
                "condition '" + condition.text + "': " + condition.path + " could not be measured in this run");
  }
  const double measured = value->get<double>();
  return ConditionOutcome{compare(measured, condition.comparison, condition.bound), measured};
}

}  // namespace kinetrace::evaluation
