// A configuration as a list of named fields, so that reading, writing and checking are written once for all types.
#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// An enumeration whose values have names: `to_string(value)` and `bool from_string(text, value)` beside its type.
struct EnumReference {
  void* value = nullptr;
  std::string_view (*get)(const void* value) = nullptr;
  bool (*set)(std::string_view text, void* value) = nullptr;
};

/// One key and a reference to its value. Must not outlive the configuration.
struct ConfigField {
  std::string key;  ///< Dotted: "features.max_features".
  std::variant<bool*, int*, float*, double*, std::string*, EnumReference> value;
  std::string doc;  ///< One line: effect, unit and range.

  [[nodiscard]] bool is_text() const noexcept {
    return std::holds_alternative<std::string*>(value) || std::holds_alternative<EnumReference>(value);
  }
};
using ConfigFields = std::vector<ConfigField>;
/// Notes for the user on accepted keys with a newer form.
using ConfigNotes = std::vector<std::string>;

inline constexpr std::string_view kConfigKeyList = "`kinetrace config` lists all keys";

template <typename Value>
[[nodiscard]] auto reference_to(Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return EnumReference{&value,
                         [](const void* v) -> std::string_view { return to_string(*static_cast<const Value*>(v)); },
                         [](std::string_view text, void* v) { return from_string(text, *static_cast<Value*>(v)); }};
  } else {
    return &value;
  }
}

/// The fields of any configuration that has `visit_fields(config, visitor)`.
template <typename Config>
[[nodiscard]] ConfigFields fields_of(Config& config) {
  ConfigFields fields;
  visit_fields(config, [&fields](std::string_view key, auto& value, std::string_view doc) {
    fields.push_back({std::string(key), reference_to(value), std::string(doc)});
  });
  return fields;
}

/// Sets the field `key` from text as written in a file or on the command line. A key of an earlier version
/// (renamed_keys.hpp) sets its replacement and adds a line to `notes`. Errors: kInvalidConfig (unknown key, with the
/// nearest known one; not a value of the field's type; not finite). `key_list`: appended to the error of an unknown
/// key; says where the keys are listed.
[[nodiscard]] Status set_field(const ConfigFields& fields, std::string_view key, std::string_view text,
                               ConfigNotes* notes = nullptr, std::string_view key_list = kConfigKeyList);

/// True if `key` is the name of a group of fields: "features" for "features.max_features".
[[nodiscard]] bool is_section(const ConfigFields& fields, std::string_view key);

/// A field's value as text that `set_field` reads back to the same value.
[[nodiscard]] std::string value_text(const ConfigField& field);

}  // namespace kinetrace::app
