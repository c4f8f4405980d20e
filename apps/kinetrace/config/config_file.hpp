// Configuration files: YAML in, commented YAML and JSON out.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "config/config_fields.hpp"

namespace kinetrace::app {

/// Expected kind of file, for messages.
struct ConfigFileKind {
  std::string missing = "no such configuration file; `kinetrace config` prints one";
  std::string unfit = "not a configuration file (a YAML text below 1 MiB)";
  std::string empty = "is empty; `kinetrace config` prints one with all keys";
  std::string key_list = std::string(kConfigKeyList);
};

/// Reads a YAML file of nested maps into `fields`; other fields keep their value. On an error some fields may already
/// be set: discard the configuration. Errors, with file and line: kNotFound, kIo, kInvalidConfig (unknown or repeated
/// key, wrong type, not finite, not YAML; an empty file, as a full disk leaves it; a file of comments alone is valid:
/// defaults). `notes`: see set_field().
[[nodiscard]] Status read_config_file(const std::filesystem::path& path, const ConfigFields& fields,
                                      const ConfigFileKind& kind = {}, ConfigNotes* notes = nullptr);

/// The same for a text; errors call it `name`.
[[nodiscard]] Status read_config_text(const std::string& name, std::string_view text, const ConfigFields& fields,
                                      ConfigNotes* notes = nullptr, std::string_view key_list = kConfigKeyList);

/// Reads a text below 1 MiB. Errors: kNotFound (message `missing`), kInvalidConfig (too large, no file; message
/// `unfit`), kIo.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& path, const std::string& missing,
                                            const std::string& unfit);

/// Paths in a file are relative to it; absolute ones and empty ones stay as they are.
void resolve_paths(const std::filesystem::path& file, std::span<std::string* const> paths);

/// Applies one `key=value` from the command line. Errors: kInvalidConfig.
[[nodiscard]] Status apply_setting(std::string_view setting, const ConfigFields& fields, ConfigNotes* notes = nullptr);

/// All fields as YAML, each with its comment; `read_config_file` reads it back to the same values.
[[nodiscard]] std::string to_yaml(const ConfigFields& fields);

/// All fields as one JSON object, nested by section.
[[nodiscard]] std::string to_json(const ConfigFields& fields);

}  // namespace kinetrace::app
