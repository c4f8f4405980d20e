#include "config/config_file.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

#include "config/renamed_keys.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/core/yaml_text.hpp"

namespace kinetrace::app {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 1 << 20;
constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // Of bytes in paths that are not UTF-8.

std::string at_line(const std::string& name, const YAML::Mark& mark) {
  return name + ":" + std::to_string(mark.line + 1) + ": ";
}

// Reads the nested maps of one file, outermost first.
class FileReader {
 public:
  FileReader(const std::string& name, const ConfigFields& fields, ConfigNotes* notes, std::string_view key_list)
      : name_(name), fields_(fields), notes_(notes), key_list_(key_list) {}

  Status read_map(const YAML::Node& map, const std::string& prefix) {
    for (const auto& entry : map) {
      if (!entry.first.IsScalar()) {
        return error(entry.first, "a key must be a plain word");
      }
      if (Status status = read_entry(entry.first, prefix + entry.first.Scalar(), entry.second); !status) {
        return status;
      }
    }
    return {};
  }

 private:
  Status read_entry(const YAML::Node& at, const std::string& key, const YAML::Node& value) {
    const std::string_view present = present_key(key);
    const auto [first, is_new] = line_of_.emplace(present.empty() ? key : present, at.Mark().line + 1);
    if (!is_new) {
      return error(at, "\"" + key + "\" is already given in line " + std::to_string(first->second) + "; keep one");
    }
    if (is_section(fields_, key)) {
      return read_section(at, key, value);
    }
    // Sets an empty text if the value is no scalar, so that an unknown key is reported first.
    const bool is_plain = value.IsScalar();
    if (Status status = set_field(fields_, key, is_plain ? value.Scalar() : std::string(), notes_, key_list_);
        !status) {
      return error(at, status.error().message);
    }
    return is_plain ? Status{} : error(at, key + " must be one value, not a list, a map or nothing");
  }

  Status read_section(const YAML::Node& at, const std::string& key, const YAML::Node& value) {
    if (value.IsNull()) {
      return {};  // A section with all its lines commented out.
    }
    if (!value.IsMap()) {
      return error(at, "\"" + key + "\" is a section; write its keys below it, indented");
    }
    return read_map(value, key + ".");
  }

  [[nodiscard]] Status error(const YAML::Node& node, const std::string& message) const {
    return fail(ErrorCode::kInvalidConfig, at_line(name_, node.Mark()) + message);
  }

  const std::string& name_;
  const ConfigFields& fields_;
  ConfigNotes* notes_;
  std::string_view key_list_;
  std::map<std::string, int> line_of_;
};

// The path of a field: its section names and its own.
std::vector<std::string> split_key(const std::string& key) {
  std::vector<std::string> parts;
  std::istringstream stream(key);
  for (std::string part; std::getline(stream, part, '.');) {
    parts.push_back(part);
  }
  return parts;
}

std::string yaml_value(const ConfigField& field) {
  // A JSON string is a YAML double-quoted string.
  return field.is_text() ? nlohmann::json(value_text(field)).dump(-1, ' ', false, kReplace) : value_text(field);
}

nlohmann::ordered_json json_value(const ConfigField& field) {
  if (field.is_text()) {
    return value_text(field);
  }
  return nlohmann::ordered_json::parse(value_text(field));
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path, const std::string& missing, const std::string& unfit) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return unreachable(path, missing);
  }
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMaxFileBytes) {
    return fail(ErrorCode::kInvalidConfig, path.string() + ": " + unfit);
  }
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) {
    return fail(ErrorCode::kIo, path.string() + ": cannot be read; check its permissions");
  }
  return text.str();
}

Status read_config_text(const std::string& name, std::string_view text, const ConfigFields& fields, ConfigNotes* notes,
                        std::string_view key_list) {
  try {
    if (const auto line = second_document_line(text)) {
      return fail(ErrorCode::kInvalidConfig, name + ":" + std::to_string(*line) + ": " + std::string(kSecondDocument));
    }
    const YAML::Node root = YAML::Load(std::string(text));
    if (root.IsNull()) {
      return {};
    }
    if (!root.IsMap()) {
      return fail(ErrorCode::kInvalidConfig, at_line(name, root.Mark()) + "expected lines of `key: value`");
    }
    return FileReader(name, fields, notes, key_list).read_map(root, "");
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kInvalidConfig, at_line(name, error.mark) + "not valid YAML: " + error.msg);
  }
}

Status read_config_file(const std::filesystem::path& path, const ConfigFields& fields, const ConfigFileKind& kind,
                        ConfigNotes* notes) {
  const Result<std::string> text = read_text(path, kind.missing, kind.unfit);
  if (!text) {
    return Unexpected(text.error());
  }
  if (text->find_first_not_of(" \t\r\n") == std::string::npos) {
    return fail(ErrorCode::kInvalidConfig, path.string() + ": " + kind.empty);
  }
  return read_config_text(path.string(), *text, fields, notes, kind.key_list);
}

void resolve_paths(const std::filesystem::path& file, std::span<std::string* const> paths) {
  for (std::string* path : paths) {
    if (!path->empty()) {
      *path = (file.parent_path() / *path).string();
    }
  }
}

Status apply_setting(std::string_view setting, const ConfigFields& fields, ConfigNotes* notes) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return fail(ErrorCode::kInvalidConfig, "--set " + std::string(setting) + ": expected key=value");
  }
  Status status = set_field(fields, setting.substr(0, equals), setting.substr(equals + 1), notes);
  if (!status) {
    return fail(status.error().code, "--set: " + status.error().message);
  }
  return status;
}

std::string to_yaml(const ConfigFields& fields) {
  std::ostringstream yaml;
  std::vector<std::string> open;  // The sections that the last line stands in.
  for (const ConfigField& field : fields) {
    std::vector<std::string> parts = split_key(field.key);
    const std::string name = parts.back();
    parts.pop_back();
    std::size_t depth = 0;
    while (depth < std::min(open.size(), parts.size()) && open[depth] == parts[depth]) {
      ++depth;
    }
    for (; depth < parts.size(); ++depth) {
      yaml << (depth == 0 ? "\n" : "") << std::string(2 * depth, ' ') << parts[depth] << ":\n";
    }
    const std::string indent(2 * depth, ' ');
    yaml << indent << "# " << field.doc << "\n" << indent << name << ": " << yaml_value(field) << "\n";
    open = std::move(parts);
  }
  return yaml.str();
}

std::string to_json(const ConfigFields& fields) {
  nlohmann::ordered_json root = nlohmann::ordered_json::object();
  for (const ConfigField& field : fields) {
    nlohmann::ordered_json* node = &root;
    for (const std::string& part : split_key(field.key)) {
      node = &(*node)[part];
    }
    *node = json_value(field);
  }
  return root.dump(2, ' ', false, kReplace);
}

}  // namespace kinetrace::app
