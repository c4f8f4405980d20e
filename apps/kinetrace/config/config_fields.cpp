#include "config/config_fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

#include "config/renamed_keys.hpp"
#include "kinetrace/core/nearest_name.hpp"

namespace kinetrace::app {
namespace {

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

// Suggests a key of the same name in another section, else the nearest spelling.
std::string suggest_key(const ConfigFields& fields, std::string_view key) {
  std::vector<std::string_view> keys;
  for (const ConfigField& field : fields) {
    if (last_part(field.key) == last_part(key)) {
      return "; did you mean " + field.key + "?";
    }
    keys.emplace_back(field.key);
  }
  return did_you_mean(key, keys);
}

Status unknown_key(const ConfigFields& fields, std::string_view key, std::string_view key_list) {
  const std::string meant = suggest_key(fields, key);
  return fail(ErrorCode::kInvalidConfig,
              "unknown key \"" + std::string(key) + "\"" + (meant.empty() ? "; " + std::string(key_list) : meant));
}

// The description of an enumeration lists its names: collect the words in it that are valid values.
std::string suggest_value(const ConfigField& field, std::string_view text) {
  const EnumReference* const choice = std::get_if<EnumReference>(&field.value);
  if (choice == nullptr) {
    return {};
  }
  const std::string before(choice->get(choice->value));
  std::vector<std::string_view> names;
  for (std::size_t begin = 0; begin < field.doc.size();) {
    const std::size_t end = std::min(field.doc.find_first_of(" ,;:()", begin), field.doc.size());
    const std::string_view word = std::string_view(field.doc).substr(begin, end - begin);
    if (choice->set(word, choice->value)) {
      names.push_back(word);
    }
    begin = end + 1;
  }
  choice->set(before, choice->value);
  return did_you_mean(text, names);
}

template <typename Number>
bool parse_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

template <typename Number>
std::string number_text(Number number) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() ? std::string(digits.data(), end) : std::string();
}

// Parses a value; returns false and leaves the target unchanged if the text is no value of its type.
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
    return number_text(*value);
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

bool has_field(const ConfigFields& fields, std::string_view key) {
  return std::any_of(fields.begin(), fields.end(), [key](const ConfigField& field) { return field.key == key; });
}

Status set_renamed_field(const ConfigFields& fields, const RenamedKey& renamed, std::string_view text,
                         ConfigNotes* notes) {
  const auto& [was, is, counted_frames] = renamed;
  if (!counted_frames) {
    if (notes != nullptr) {
      notes->push_back(std::string(was) +
                       (is.empty() ? " has no effect any more; remove it" : " is now " + std::string(is)));
    }
    return is.empty() ? Status{} : set_field(fields, is, text);
  }
  int frames = 0;
  if (!parse_number(text, frames)) {
    return fail(ErrorCode::kInvalidConfig, std::string(was) + " must be a whole number, got \"" + std::string(text) +
                                               "\"; it is called " + std::string(is) + " now, in seconds");
  }
  const std::string seconds = number_text(frames / kFramesPerSecond);
  if (notes != nullptr) {
    notes->push_back(std::string(was) + " is now " + std::string(is) + ": " + std::string(text) +
                     " frames are read as " + seconds + " s");
  }
  return set_field(fields, is, seconds);
}

}  // namespace

Status set_field(const ConfigFields& fields, std::string_view key, std::string_view text, ConfigNotes* notes,
                 std::string_view key_list) {
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const ConfigField& f) { return f.key == key; });
  if (field == fields.end()) {
    const RenamedKey* const renamed = renamed_key(key);
    const bool is_known = renamed != nullptr && (renamed->is.empty() || has_field(fields, renamed->is));
    return is_known ? set_renamed_field(fields, *renamed, text, notes) : unknown_key(fields, key, key_list);
  }
  if (!std::visit(Assign{text}, field->value)) {
    return fail(ErrorCode::kInvalidConfig, field->key + " must be " +
                                               std::visit(Expectation{field->doc}, field->value) + ", got \"" +
                                               std::string(text) + "\"" + suggest_value(*field, text));
  }
  return {};
}

bool is_section(const ConfigFields& fields, std::string_view key) {
  const std::string prefix = std::string(key) + ".";
  return std::any_of(fields.begin(), fields.end(), [&](const auto& field) { return field.key.starts_with(prefix); }) ||
         std::any_of(kRenamedKeys.begin(), kRenamedKeys.end(), [&](const RenamedKey& renamed) {
           return renamed.was.starts_with(prefix) && has_field(fields, renamed.is);
         });
}

std::string value_text(const ConfigField& field) {
  return std::visit(Text{}, field.value);
}

}  // namespace kinetrace::app
