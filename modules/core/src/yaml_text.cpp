#include "kinetrace/core/yaml_text.hpp"

namespace kinetrace {
namespace {

bool is_marker(std::string_view line, std::string_view marker) {
  return line.starts_with(marker) && (line.size() == marker.size() ||
                                      std::string_view(" \t\r").find(line[marker.size()]) != std::string_view::npos);
}

bool says_nothing(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string_view::npos || line[first] == '#' || line.front() == '%';
}

}  // namespace

// YAML 1.2.2, 9.1: a line that begins with a document marker is one even inside a quoted text.
std::optional<int> second_document_line(std::string_view yaml) {
  bool has_begun = false;
  bool has_ended = false;
  for (int line_number = 1; !yaml.empty(); ++line_number) {
    const std::size_t end = yaml.find('\n');
    const std::string_view line = yaml.substr(0, end);
    yaml.remove_prefix(end == std::string_view::npos ? yaml.size() : end + 1);
    if (is_marker(line, "...")) {
      has_ended = has_begun;
    } else if (is_marker(line, "---") || !says_nothing(line)) {
      if (has_ended || (has_begun && is_marker(line, "---"))) {
        return line_number;
      }
      has_begun = true;
    }
  }
  return std::nullopt;
}

}  // namespace kinetrace
