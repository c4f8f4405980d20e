#include "config_fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <system_error>

namespace kinetrace::app {
namespace {

// Levenshtein's edit distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j + 1] + 1, row[j] + 1, replaced});
    }
  }
  return row.back();
}

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

// The known key a user most likely meant: the same name in another section, or a few letters away.
std::optional<std::string_view> nearest_key(const ConfigFields& fields, std::string_view key) {
  std::optional<std::string_view> nearest;
  std::size_t smallest = std::max<std::size_t>(2, key.size() / 4) + 1;
  for (const ConfigField& field : fields) {
    const bool same_name = last_part(field.key) == last_part(key);
    const std::size_t distance = same_name ? 1 : edit_distance(key, field.key);
    if (distance < smallest) {
      smallest = distance;
      nearest = field.key;
    }
  }
  return nearest;
}

Status unknown_key(const ConfigFields& fields, std::string_view key) {
  std::string message = "unknown key \"" + std::string(key) + "\"";
  if (const auto nearest = nearest_key(fields, key)) {
    message += "; did you mean \"" + std::string(*nearest) + "\"?";
  } else {
    message += "; `kinetrace config` lists all keys";
  }
  return fail(ErrorCode::kInvalidConfig, std::move(message));
}

template <typename Number>
bool parse_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

// Values from text; false, and nothing changed, if the text is no value of the type.
struct Assign {
  std::string_view text;

  bool operator()(bool* target) const {
    if (text != "true" && text != "false") {
      return false;
    }
    *target = text == "true";
    return true;
  }
  bool operator()(int* target) const {
    int number = 0;
    const bool is_valid = parse_number(text, number);
    *target = is_valid ? number : *target;
    return is_valid;
  }
  template <typename Float>
  bool operator()(Float* target) const {
    Float number = 0;
    const bool is_valid = parse_number(text, number) && std::isfinite(number);
    *target = is_valid ? number : *target;
    return is_valid;
  }
  bool operator()(std::string* target) const {
    *target = text;
    return true;
  }
  bool operator()(const EnumReference& target) const { return target.set(text, target.value); }
};

struct Text {
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return *value; }
  std::string operator()(const EnumReference& value) const { return std::string(value.get(value.value)); }
  template <typename Number>
  std::string operator()(const Number* value) const {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), *value);
    return error == std::errc() ? std::string(digits.data(), end) : std::string();
  }
};

struct Expectation {
  const std::string& doc;

  std::string operator()(const bool* /*value*/) const { return "true or false"; }
  std::string operator()(const int* /*value*/) const { return "a whole number"; }
  std::string operator()(const EnumReference& /*value*/) const { return doc; }  // Lists the names.
  template <typename Float>
  std::string operator()(const Float* /*value*/) const {
    return "a finite number";
  }
};

}  // namespace

Status set_field(const ConfigFields& fields, std::string_view key, std::string_view text) {
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const ConfigField& f) { return f.key == key; });
  if (field == fields.end()) {
    return unknown_key(fields, key);
  }
  if (!std::visit(Assign{text}, field->value)) {
    return fail(ErrorCode::kInvalidConfig, field->key + " must be " +
                                               std::visit(Expectation{field->doc}, field->value) + ", got \"" +
                                               std::string(text) + "\"");
  }
  return {};
}

bool is_section(const ConfigFields& fields, std::string_view key) {
  const std::string prefix = std::string(key) + ".";
  return std::any_of(fields.begin(), fields.end(),
                     [&](const ConfigField& field) { return field.key.compare(0, prefix.size(), prefix) == 0; });
}

std::string value_text(const ConfigField& field) {
  return std::visit(Text{}, field.value);
}

}  // namespace kinetrace::app
