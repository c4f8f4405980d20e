#include "config/size_file.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "config/config_file.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/yaml_text.hpp"

namespace kinetrace::app {
namespace {

using trajectory::BodyShape;
using trajectory::KindOfObject;
using trajectory::SizeTable;

// Deviations below a millimetre would outweigh every measurement, and overflow once squared.
constexpr float kMinSize_m = 0.001F;
constexpr float kMaxSize_m = 100.F;
constexpr float kMinShare = 0.001F;

/// Reads the kinds in order until the first error.
class SizeReader {
 public:
  explicit SizeReader(std::string name) : name_(std::move(name)) {}

  Result<SizeTable> read(const YAML::Node& root) {
    const YAML::Node list = root.IsMap() ? root["kinds"] : YAML::Node();
    if (!list || !list.IsSequence() || root.size() != 1) {
      refuse(root, "expected one list, `kinds:`; see config/sizes.yaml");
      return Unexpected(status_.error());
    }
    std::vector<KindOfObject> kinds;
    for (const YAML::Node& node : list) {
      kinds.push_back(kind_of(node));
    }
    if (kinds.size() > SizeTable::kMaxKinds) {
      refuse(list, "there are " + std::to_string(kinds.size()) + " kinds; " + std::to_string(SizeTable::kMaxKinds) +
                       " is the most");
    }
    std::stable_sort(kinds.begin(), kinds.end(),
                     [](const KindOfObject& a, const KindOfObject& b) { return a.class_id < b.class_id; });
    const SizeTable table{kinds};
    if (table.kinds_of(SizeTable::kOtherClasses).empty()) {
      refuse(list, "there is no kind of class `other`, for classes that are not listed");
    }
    return status_ ? Result<SizeTable>(table) : Unexpected(status_.error());
  }

 private:
  KindOfObject kind_of(const YAML::Node& node) {
    KindOfObject kind;
    if (!node.IsMap()) {
      refuse(node, "a kind must be a map: class, share, length, height, width, shape");
      return kind;
    }
    check_keys(node);
    kind.class_id = class_of(node["class"], node);
    kind.share = number_in(node["share"], node, "share", {kMinShare, 1.F});
    constexpr std::array<const char*, 3> kDimensions{"length", "height", "width"};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const char* key = kDimensions[static_cast<std::size_t>(i)];
      const YAML::Node pair = node[key];
      if (!pair || !pair.IsSequence() || pair.size() != 2) {
        refuse(node, std::string(key) + " must be [mean, standard deviation] in m");
        continue;
      }
      kind.mean_m[i] = number_in(pair[0], pair, key, {kMinSize_m, kMaxSize_m});
      kind.sigma_m[i] = number_in(pair[1], pair, key, {kMinSize_m, kMaxSize_m});
    }
    const std::string shape = node["shape"] && node["shape"].IsScalar() ? node["shape"].Scalar() : std::string();
    if (shape != "box" && shape != "saloon") {
      refuse(node, "shape must be box or saloon");
    }
    kind.shape = shape == "saloon" ? BodyShape::kSaloon : BodyShape::kBox;
    return kind;
  }

  void check_keys(const YAML::Node& node) {
    std::vector<std::string> seen;
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : std::string();
      if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys)) {
        refuse(entry.first, "unknown key \"" + key + "\"; there are: class, share, length, height, width, shape");
      }
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        refuse(entry.first, "\"" + key + "\" stands there twice");
      }
      seen.push_back(key);
    }
  }

  std::uint16_t class_of(const YAML::Node& node, const YAML::Node& at) {
    const std::string name = node && node.IsScalar() ? node.Scalar() : std::string();
    int number = 0;
    if (name == "car") {
      return kVehicleClass;
    }
    if (name == "pedestrian") {
      return kPedestrianClass;
    }
    if (name == "unknown") {
      return kUnknownClass;
    }
    if (name == "other") {
      return SizeTable::kOtherClasses;
    }
    if (!node || !YAML::convert<int>::decode(node, number) || number < 0 || number >= SizeTable::kOtherClasses) {
      refuse(at, "class must be car, pedestrian, unknown, other or a number of the segmentation, got \"" + name + "\"");
    }
    return static_cast<std::uint16_t>(number);
  }

  float number_in(const YAML::Node& node, const YAML::Node& at, const char* key, const std::array<float, 2>& range) {
    float value = 0.F;
    if (!node || !node.IsScalar() || !YAML::convert<float>::decode(node, value) ||
        !(value >= range[0] && value <= range[1])) {
      refuse(at, std::string(key) + " must be a number from 0.001 to " + std::to_string(static_cast<int>(range[1])));
      return range[1];
    }
    return value;
  }

  void refuse(const YAML::Node& node, const std::string& message) {
    if (status_) {
      // An empty file has no line at all.
      const int line = std::max(node.Mark().line, 0) + 1;
      status_ = fail(ErrorCode::kInvalidConfig, name_ + ":" + std::to_string(line) + ": " + message);
    }
  }

  static constexpr std::array<const char*, 6> kKeys{"class", "share", "length", "height", "width", "shape"};
  std::string name_;
  Status status_;
};

}  // namespace

Result<SizeTable> read_size_file(const std::filesystem::path& path) {
  const Result<std::string> text = read_text(path, "no such file of sizes; config/sizes.yaml is one",
                                             "not a file of sizes (a YAML text below 1 MiB)");
  if (!text) {
    return Unexpected(text.error());
  }
  if (const auto line = second_document_line(*text)) {
    return fail(ErrorCode::kInvalidConfig,
                path.string() + ":" + std::to_string(*line) + ": " + std::string(kSecondDocument));
  }
  try {
    return SizeReader(path.string()).read(YAML::Load(*text));
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kInvalidConfig,
                path.string() + ":" + std::to_string(error.mark.line + 1) + ": not valid YAML: " + error.msg);
  }
}

}  // namespace kinetrace::app
