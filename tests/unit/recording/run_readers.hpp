// Strict readers of run folders. They throw std::runtime_error on any deviation from the documentation.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::recording {

[[nodiscard]] std::string read_text(const std::filesystem::path& path);
/// Lines without their ends; the last one must end too.
[[nodiscard]] std::vector<std::string> read_lines(const std::filesystem::path& path);
/// Fields between single separators; empty for an empty line.
[[nodiscard]] std::vector<std::string> split(std::string_view line, char separator);
[[nodiscard]] double to_double(const std::string& text);
[[nodiscard]] std::int64_t to_integer(const std::string& text);

struct TumRow {
  std::string timestamp;
  Se3 pose;
};
[[nodiscard]] std::vector<TumRow> read_tum(const std::filesystem::path& path);

/// Rows of a CSV file, by column name.
[[nodiscard]] std::vector<std::map<std::string, std::string>> read_csv(const std::filesystem::path& path);

struct PlyVertex {
  Eigen::Vector3f position_m;
  std::array<std::uint8_t, 3> rgb{};
  std::int32_t frame = 0;
  std::uint32_t point_id = 0;
};
struct PlyFile {
  std::string comment;
  std::vector<PlyVertex> vertices;
};
[[nodiscard]] PlyFile read_ply(const std::filesystem::path& path);

struct ColmapImage {
  Se3 T_cam_body;
  std::string name;
  std::vector<Eigen::Vector2d> points_px;
  std::vector<std::int64_t> point_ids;  ///< -1 = none.
};
struct ColmapPoint {
  Eigen::Vector3d position_m;
  int gray = 0;
  double error_px = 0.0;
  std::vector<std::pair<std::int64_t, std::size_t>> track;  ///< (image id, index of its 2-D point).
};
struct ColmapModel {
  std::array<double, 6> camera{};  ///< width height fx fy cx cy.
  std::map<std::int64_t, ColmapImage> images;
  std::map<std::int64_t, ColmapPoint> points;
};
/// Reads a text model and checks that images and points refer to each other consistently.
[[nodiscard]] ColmapModel read_colmap(const std::filesystem::path& directory);

}  // namespace kinetrace::recording
