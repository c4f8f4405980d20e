#include "segmentation/model_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "cli/program_folder.hpp"
#include "config/config_file.hpp"
#include "kinetrace/core/yaml_text.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;
using neural::InputColours;
using neural::InputFit;
using neural::ModelClass;
using neural::ModelConfig;
using neural::ModelFamily;
using neural::TrainingPictures;

constexpr const char* kDefaultModel = "kinetrace-sim.yaml";

template <typename Value>
using Names = std::initializer_list<std::pair<const char*, Value>>;

/// Reads the maps of the file in order until the first error.
class ModelReader {
 public:
  explicit ModelReader(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] Result<ModelConfig> read(const YAML::Node& root) {
    ModelConfig model;
    allow(
        root, "",
        {"family", "model", "graph", "trained_on", "input", "classes", "use", "thresholds", "calibration", "anchors"});
    choose(root, "family",
           Names<ModelFamily>{{"yolov5-seg", ModelFamily::kYolov5Seg},
                              {"yolov8-seg", ModelFamily::kYolov8Seg},
                              {"yolo11-seg", ModelFamily::kYolo11Seg},
                              {"kinetrace-seg", ModelFamily::kKinetraceSeg},
                              {"mask-rcnn", ModelFamily::kMaskRcnn}},
           model.family);
    text(root, "model", model.file);
    text(root, "graph", model.graph);
    choose(root, "trained_on",
           Names<TrainingPictures>{{"real", TrainingPictures::kReal}, {"rendered", TrainingPictures::kRendered}},
           model.trained_on);
    read_input(root, model.input);
    read_classes(root, model.classes);
    read_scores(root, model);
    numbers(root, "anchors", model.anchors_px, model.anchors_px.size());
    return status_ ? Result<ModelConfig>(std::move(model)) : Unexpected(status_.error());
  }

 private:
  void read_input(const YAML::Node& root, neural::ModelInput& input) {
    const YAML::Node map = section(
        root, "input", {"width", "height", "pixels", "colours", "fit", "disparity", "scale", "mean", "std", "pad"});
    number(map, "width", input.width_px);
    number(map, "height", input.height_px);
    number(map, "pixels", input.max_pixels);
    if (map["pixels"] && (map["width"] || map["height"])) {
      refuse(map["pixels"], "input.pixels lets the size follow the pictures; give that, or width and height");
    }
    choose(map, "colours",
           Names<InputColours>{{"gray", InputColours::kGray}, {"rgb", InputColours::kRgb}, {"bgr", InputColours::kBgr}},
           input.colours);
    choose(map, "disparity", Names<bool>{{"true", true}, {"false", false}}, input.disparity);
    choose(map, "fit", Names<InputFit>{{"letterbox", InputFit::kLetterbox}, {"stretch", InputFit::kStretch}},
           input.fit);
    number(map, "scale", input.scale);
    const auto channels = static_cast<std::size_t>(input.colour_channels());
    numbers(map, "mean", input.mean, channels);
    numbers(map, "std", input.deviation, channels);
    number(map, "pad", input.pad);
  }

  void read_classes(const YAML::Node& root, std::vector<ModelClass>& classes) {
    const YAML::Node names = root["classes"];
    if (names && !names.IsSequence()) {
      return refuse(names, "classes must be a list of names, in the order of the network");
    }
    for (const YAML::Node& name : names) {
      if (!name.IsScalar() || name.Scalar().empty()) {
        return refuse(name, "classes: class " + std::to_string(classes.size()) + " has no name");
      }
      classes.push_back({name.Scalar(), ModelClass::kDropped});
    }
    const YAML::Node uses = root["use"];
    if (uses && !uses.IsMap()) {
      return refuse(uses, "use must be lines of `class: vehicle`, person, ignore or drop");
    }
    for (const auto& entry : uses) {
      const auto has_name = [&](const ModelClass& one) { return one.name == entry.first.Scalar(); };
      const auto named = std::find_if(classes.begin(), classes.end(), has_name);
      if (named == classes.end()) {
        return refuse(entry.first, "use: \"" + entry.first.Scalar() + "\" is none of the classes");
      }
      // Unused ones may share a name: lists of classes have gaps, such as "N/A".
      if (std::any_of(named + 1, classes.end(), has_name)) {
        return refuse(entry.first, "use: several classes are named \"" + named->name + "\"; give each its own name");
      }
      choose(uses, named->name.c_str(),
             Names<std::uint16_t>{{"vehicle", kVehicleClass},
                                  {"person", kPedestrianClass},
                                  {"ignore", kIgnoreClass},
                                  {"drop", ModelClass::kDropped}},
             named->class_id);
    }
    const bool any_is_used = std::any_of(classes.begin(), classes.end(),
                                         [](const ModelClass& one) { return one.class_id != ModelClass::kDropped; });
    if (!any_is_used) {
      refuse(root, "use must say of at least one class that it is vehicle, person or ignore; others are dropped");
    }
  }

  /// Reads thresholds and the calibration of scores, common to all classes or by class.
  void read_scores(const YAML::Node& root, ModelConfig& model) {
    const YAML::Node thresholds = section(root, "thresholds", {"score", "overlap"});
    number(thresholds, "overlap", model.thresholds.overlap);
    const YAML::Node calibration = root["calibration"];
    const bool is_for_all = calibration && calibration.IsMap() && (calibration["slope"] || calibration["even"]);
    std::vector<std::string> names;
    std::transform(model.classes.begin(), model.classes.end(), std::back_inserter(names),
                   [](const ModelClass& one) { return one.name; });
    const YAML::Node by_class = is_for_all ? YAML::Node() : section(root, "calibration", names);
    for (ModelClass& one : model.classes) {
      number(thresholds, "score", one.min_score);
      // Default: the threshold was chosen as the score of even odds. Scores of such heads are underconfident: for the
      // bundled network on simulated worlds the slope is 2.
      one.calibration = {.slope = 2.F, .even = std::clamp(one.min_score, 0.01F, 0.99F)};
      const YAML::Node own = is_for_all ? section(root, "calibration", {"slope", "even"})
                                        : section(by_class, one.name.c_str(), {"slope", "even"});
      number(own, "slope", one.calibration.slope);
      number(own, "even", one.calibration.even);
      if (!thresholds["score"] && own["even"]) {
        one.min_score = one.calibration.even;
      }
    }
  }

  void allow(const YAML::Node& map, const std::string& prefix, const std::vector<std::string>& keys) {
    std::map<std::string, int> line_of;
    for (const auto& entry : map) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : std::string();
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        std::string known;
        for (const std::string& one : keys) {
          known += (known.empty() ? "" : ", ") + one;
        }
        std::string message = "unknown key \"" + prefix;
        return refuse(entry.first, message.append(key).append("\"; there are: ").append(known));
      }
      const auto [first, is_new] = line_of.emplace(key, entry.first.Mark().line + 1);
      if (!is_new) {
        std::string message = "\"" + prefix;
        message.append(key).append("\" is already given in line ");
        return refuse(entry.first, message.append(std::to_string(first->second)));
      }
    }
  }
  [[nodiscard]] YAML::Node section(const YAML::Node& root, const char* key, const std::vector<std::string>& keys) {
    const YAML::Node map = root[key];
    if (!map) {
      return YAML::Node(YAML::NodeType::Map);
    }
    if (!map.IsMap()) {
      refuse(map, std::string("\"") + key + "\" is a section of keys");
      return YAML::Node(YAML::NodeType::Map);
    }
    allow(map, std::string(key) + ".", keys);
    return map;
  }
  void text(const YAML::Node& map, const char* key, std::string& value) {
    const YAML::Node node = map[key];
    if (node && !node.IsScalar()) {
      return refuse(node, std::string(key) + " must be one value");
    }
    value = node ? node.Scalar() : value;
  }
  template <typename Value>
  void choose(const YAML::Node& map, const char* key, Names<Value> names, Value& value) {
    const YAML::Node node = map[key];
    if (!node) {
      return;
    }
    std::string known;
    for (const auto& [name, meaning] : names) {
      if (node.IsScalar() && node.Scalar() == name) {
        value = meaning;
        return;
      }
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    refuse(node, std::string(key) + " must be one of: " + known);
  }
  template <typename Value>
  void number(const YAML::Node& map, const char* key, Value& value) {
    if (const YAML::Node node = map[key]) {
      value = as_number<Value>(node, key);
    }
  }
  template <typename Value>
  [[nodiscard]] Value as_number(const YAML::Node& node, const char* key) {
    constexpr double kLargest = 1e9;
    double read = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) || !std::isfinite(read) ||
        (std::is_integral_v<Value> && read != std::floor(read))) {
      refuse(node, std::string(key) + " must be a " + (std::is_integral_v<Value> ? "whole " : "finite ") + "number");
      return Value{};
    }
    if (std::abs(read) > kLargest) {
      refuse(node, std::string(key) + " must be within -1e9 and 1e9, got " + node.Scalar());
      return Value{};
    }
    return static_cast<Value>(read);
  }
  template <typename Array>
  void numbers(const YAML::Node& map, const char* key, Array& values, std::size_t count) {
    const YAML::Node node = map[key];
    if (!node) {
      return;
    }
    if (!node.IsSequence() || node.size() != count) {
      return refuse(node, std::string(key) + " must be a list of " + std::to_string(count) + " numbers");
    }
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = as_number<float>(node[i], key);
    }
  }
  void refuse(const YAML::Node& node, const std::string& message) {
    if (status_) {
      status_ = fail(ErrorCode::kInvalidConfig, name_ + ":" + std::to_string(node.Mark().line + 1) + ": " + message);
    }
  }

  std::string name_;
  Status status_;
};

Result<std::string> text_of(const fs::path& path) {
  const std::string guide = "see the guide \"Your own model\" in modules/neural/README.md";
  const std::string unfit =
      "is not the description of a model; write a YAML file beside the network, " + guide + ", and give that";
  const fs::path ending = path.extension();
  std::error_code error;
  if ((ending == ".onnx" || ending == ".pb") && fs::exists(path, error)) {
    return fail(ErrorCode::kInvalidConfig, path.string() + ": " + unfit);
  }
  return read_text(path, "no such model; give the YAML file that describes a network, " + guide, unfit);
}

// kinetrace-simulate writes ground truth a few folders above the rendered pictures.
bool is_rendered(const fs::path& pictures) {
  constexpr int kFolders = 6;
  std::error_code error;
  fs::path folder = fs::weakly_canonical(pictures, error);
  for (int i = 0; i < kFolders && !error && !pictures.empty(); ++i, folder = folder.parent_path()) {
    if (fs::exists(folder / "truth" / "objects.csv", error)) {
      return true;
    }
    error.clear();
  }
  return false;
}

Result<fs::path> default_model() {
  for (const char* place : {"models", "../share/kinetrace/models"}) {
    const fs::path path = program_folder() / place / kDefaultModel;
    std::error_code error;
    if (fs::exists(path, error)) {
      return path;
    }
  }
  return fail(ErrorCode::kNotFound,
              std::string("segmentation.onnx.model is empty, and ") + kDefaultModel +
                  ", which comes with Kinetrace, is not installed; install the package kinetrace-networks, or "
                  "name a model");
}

}  // namespace

std::optional<std::string> model_caution(const ModelConfig& model, const fs::path& pictures) {
  if (model.trained_on == TrainingPictures::kReal || is_rendered(pictures)) {
    return std::nullopt;
  }
  return model.file +
         " was trained on rendered pictures alone and finds fewer objects in real ones, people most of all; give a "
         "network that was trained on pictures like these (--segmentation onnx:MODEL.yaml, segment --model), see "
         "modules/neural/README.md";
}

Result<ModelConfig> load_model(const fs::path& path) {
  if (path.empty()) {
    const Result<fs::path> shipped = default_model();
    return shipped ? load_model(*shipped) : Unexpected(shipped.error());
  }
  const Result<std::string> text = text_of(path);
  if (!text) {
    return Unexpected(text.error());
  }
  Result<ModelConfig> model = [&]() -> Result<ModelConfig> {
    try {
      if (const auto line = second_document_line(*text)) {
        return fail(ErrorCode::kInvalidConfig,
                    path.string() + ":" + std::to_string(*line) + ": " + std::string(kSecondDocument));
      }
      const YAML::Node root = YAML::Load(*text);
      if (!root.IsMap()) {
        return fail(ErrorCode::kInvalidConfig, path.string() + ": expected lines of `key: value`");
      }
      return ModelReader(path.string()).read(root);
    } catch (const YAML::Exception& error) {
      return fail(ErrorCode::kInvalidConfig,
                  path.string() + ":" + std::to_string(error.mark.line + 1) + ": not valid YAML: " + error.msg);
    }
  }();
  if (!model) {
    return model;
  }
  resolve_paths(path, std::array{&model->file, &model->graph});
  if (const Status valid = model->validate(); !valid) {
    return fail(valid.error().code, path.string() + ": " + valid.error().message);
  }
  return model;
}

}  // namespace kinetrace::app
