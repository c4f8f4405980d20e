#include "calibration/yaml_document.hpp"

#include <cmath>
#include <set>

#include "kinetrace/core/yaml_text.hpp"
#include "util/messages.hpp"
#include "util/row_major.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

constexpr std::size_t kMaxNodes = std::size_t{1} << 20;
constexpr int kMaxDepth = 16;

// Rejects trees that are unsafe to traverse. An alias may contain itself, or double the number of values with every
// line of the file: depth and number of values are therefore bounded here, once for all traversals.
class TreeCheck {
 public:
  std::optional<std::string> problem(const YAML::Node& node, const std::string& place = {}, int depth = 0) {
    if (depth > kMaxDepth) {
      return concat("'", place, "' is nested more than ", std::to_string(kMaxDepth),
                    " levels deep; does an alias (*) contain itself? Write the values out");
    }
    if (++nodes_ > kMaxNodes) {
      return concat("holds more than ", std::to_string(kMaxNodes),
                    " values once its aliases (*) are replaced; write the values out");
    }
    return node.IsMap() ? problem_of_map(node, place, depth) : problem_of_list(node, place, depth);
  }

 private:
  std::optional<std::string> problem_of_map(const YAML::Node& map, const std::string& place, int depth) {
    std::set<std::string> seen;
    for (const auto& entry : map) {
      const std::string key =
          concat(place, place.empty() ? "" : ".", entry.first.IsScalar() ? entry.first.Scalar() : "");
      // yaml-cpp keeps duplicates and finds only the first: the second would be ignored silently.
      if (!seen.insert(key).second) {
        return concat("'", key, "' is there twice; remove one");
      }
      if (auto below = problem(entry.second, key, depth + 1)) {
        return below;
      }
    }
    return std::nullopt;
  }

  std::optional<std::string> problem_of_list(const YAML::Node& list, const std::string& place, int depth) {
    for (const YAML::Node& element : list) {  // Empty for a plain value.
      if (auto below = problem(element, place, depth + 1)) {
        return below;
      }
    }
    return std::nullopt;
  }

  std::size_t nodes_ = 0;
};

std::optional<std::string> append_numbers(const YAML::Node& node, std::vector<double>& numbers) {
  if (node.IsSequence()) {
    for (const YAML::Node& element : node) {
      if (auto problem = append_numbers(element, numbers)) {
        return problem;
      }
    }
    return std::nullopt;
  }
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value)) {
    return concat("holds '", node.IsScalar() ? node.Scalar() : std::string("a map"), "' where a number must be");
  }
  if (!std::isfinite(value)) {
    return concat("holds ", number(value), ", which is no finite number; calibrate again");
  }
  numbers.push_back(value);
  return std::nullopt;
}

}  // namespace

Result<YamlDocument> YamlDocument::load(const std::filesystem::path& path) {
  return read_text(path, kMaxCalibrationBytes).and_then([&path](std::string text) {
    if (path.extension() == ".xml") {
      return parse_xml(path, text);
    }
    if (path.extension() == ".json") {
      // JSON is YAML except for tabs between values.
      std::replace(text.begin(), text.end(), '\t', ' ');
    }
    return parse(path, std::move(text));
  });
}

Result<YamlDocument> YamlDocument::parse(const std::filesystem::path& path, std::string text) {
  if (text.starts_with("%YAML")) {
    text.erase(0, std::min(text.find('\n'), text.size()));
  }
  if (const auto line = second_document_line(text)) {
    return fail(ErrorCode::kBadCalibration,
                concat(path.string(), ": line ", std::to_string(*line), ": ", kSecondDocument));
  }
  YamlDocument document;
  document.path_ = path;
  try {
    document.root_ = YAML::Load(text);
  } catch (const YAML::Exception& exception) {
    return fail(ErrorCode::kBadCalibration, concat(path.string(), ": is no valid YAML (line ",
                                                   std::to_string(exception.mark.line + 1), ": ", exception.msg, ")"));
  }
  if (!document.root_.IsMap()) {
    return fail(ErrorCode::kBadCalibration, path.string() + ": is no YAML map; expected 'key: value' lines");
  }
  if (const auto problem = TreeCheck().problem(document.root_)) {
    return fail(ErrorCode::kBadCalibration, concat(path.string(), ": ", *problem));
  }
  return document;
}

std::optional<YAML::Node> YamlDocument::find(std::string_view key) const {
  YAML::Node node = root_;
  while (!key.empty()) {
    const std::size_t end = key.find('.');
    if (!node.IsMap()) {
      return std::nullopt;
    }
    const YAML::Node& parent = node;
    const YAML::Node child = parent[std::string(key.substr(0, end))];
    if (!child.IsDefined()) {
      return std::nullopt;
    }
    node.reset(child);
    key.remove_prefix(end == std::string_view::npos ? key.size() : end + 1);
  }
  return node;
}

std::string YamlDocument::first_of(const std::vector<std::string>& keys) const {
  const auto found = std::find_if(keys.begin(), keys.end(), [this](const std::string& key) { return has(key); });
  return found == keys.end() ? std::string() : *found;
}

Result<std::string> YamlDocument::text(std::string_view key) const {
  const auto node = find(key);
  if (!node || !node->IsScalar()) {
    return error(key, "is missing");
  }
  return node->Scalar();
}

Result<std::vector<double>> YamlDocument::numbers(std::string_view key) const {
  const auto node = find(key);
  if (!node) {
    return error(key, "is missing");
  }
  const YAML::Node& found = *node;
  std::vector<double> values;
  const YAML::Node data = found.IsMap() ? found["data"] : found;
  if (!data.IsDefined()) {
    return error(key, "has no 'data'");
  }
  if (const auto problem = append_numbers(data, values)) {
    return error(key, *problem);
  }
  return values;
}

Result<std::vector<double>> YamlDocument::numbers(std::string_view key, std::size_t count) const {
  Result<std::vector<double>> values = numbers(key);
  if (values && values->size() != count) {
    return error(key, concat("must be ", std::to_string(count), " numbers, got ", std::to_string(values->size())));
  }
  return values;
}

Result<Eigen::Matrix3d> YamlDocument::matrix3(std::string_view key) const {
  return numbers(key, 9).transform(row_major<3, 3>);
}

Result<Se3> YamlDocument::transform(std::string_view key) const {
  const Result<std::vector<double>> values = numbers(key, 16);
  if (!values) {
    return Unexpected(values.error());
  }
  const Eigen::Matrix4d matrix = row_major<4, 4>(*values);
  if (!matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1))) {
    return error(key, "is no rigid transform: its last row must be 0 0 0 1");
  }
  return Se3{matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()};
}

Unexpected<Error> YamlDocument::error(std::string_view key, std::string_view what) const {
  return fail(ErrorCode::kBadCalibration, concat(path_.string(), ": '", key, "' ", what));
}

}  // namespace kinetrace::hal
