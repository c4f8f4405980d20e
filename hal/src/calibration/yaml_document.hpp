// Calibration files in YAML, as OpenCV, Kalibr, ROS and EuRoC write them, and OpenCV's in JSON and XML.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <yaml-cpp/yaml.h>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::hal {

/// One file. Keys are dotted paths: "cam0.intrinsics". Errors are kBadCalibration and name the file and the key.
class YamlDocument {
 public:
  /// Format by extension: .xml, .json, else YAML. Errors: as read_text, for a text below 1 MiB; as parse, parse_xml.
  [[nodiscard]] static Result<YamlDocument> load(const std::filesystem::path& path);
  /// Accepts OpenCV's first line "%YAML:1.0", which is no YAML. Errors, naming the file as `path`: kBadCalibration (no
  /// YAML, duplicate keys, nested too deep or too large once aliases are replaced).
  [[nodiscard]] static Result<YamlDocument> parse(const std::filesystem::path& path, std::string text);

  /// The same from the XML of cv::FileStorage. Errors: kBadCalibration (no XML, elements twice or nested too deep).
  [[nodiscard]] static Result<YamlDocument> parse_xml(const std::filesystem::path& path, std::string_view text);

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] bool has(std::string_view key) const { return find(key).has_value(); }
  /// The first of several spellings that the file has, else empty.
  [[nodiscard]] std::string first_of(const std::vector<std::string>& keys) const;

  [[nodiscard]] Result<std::string> text(std::string_view key) const;
  /// A number, a list, nested lists or a matrix ({rows, cols, data}) flattened row by row; all finite.
  [[nodiscard]] Result<std::vector<double>> numbers(std::string_view key) const;
  /// The same, exactly `count` of them.
  [[nodiscard]] Result<std::vector<double>> numbers(std::string_view key, std::size_t count) const;
  [[nodiscard]] Result<Eigen::Matrix3d> matrix3(std::string_view key) const;
  /// A 4x4 matrix whose last row is 0 0 0 1.
  [[nodiscard]] Result<Se3> transform(std::string_view key) const;

  [[nodiscard]] Unexpected<Error> error(std::string_view key, std::string_view what) const;

 private:
  [[nodiscard]] std::optional<YAML::Node> find(std::string_view key) const;
  std::filesystem::path path_;
  YAML::Node root_;
};

}  // namespace kinetrace::hal
