#include "target_drawing.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "kinetrace/core/files.hpp"
#include "marker_bits.hpp"

namespace kinetrace::calibration {
namespace {

constexpr const char* kSvgBegin = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"";

// The top left square is black, except on boards that begin with a marker.
void add_squares(const Target& target, std::vector<BlackRectangle>& black) {
  const bool is_charuco = target.kind == TargetKind::kCharuco;
  const int columns = target.columns + (is_charuco ? 0 : 1);
  const int rows = target.rows + (is_charuco ? 0 : 1);
  const bool begins_white = is_charuco && target.markers.front().corners_m[0].x() < 0.0;
  const double side_m = target.square_m;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (((row + column) % 2 == 0) != begins_white) {
        black.push_back({{(column - 1) * side_m, (row - 1) * side_m}, {column * side_m, row * side_m}});
      }
    }
  }
}

// Adjacent cells in a row form one rectangle, so that printers leave no gaps between them.
bool add_marker(const Target& target, const Marker& marker, std::vector<BlackRectangle>& black) {
  const MarkerBits bits = marker_bits(target, marker.id);
  const Eigen::Vector2d corner = marker.corners_m[0].head<2>();
  const double cell_m =
      (marker.corners_m[1].x() - corner.x()) / static_cast<double>(std::max<std::size_t>(bits.size(), 1));
  for (std::size_t y = 0; y < bits.size(); ++y) {
    for (std::size_t x = 0; x < bits.size();) {
      std::size_t end = x;
      while (end < bits.size() && bits[y][end]) {
        ++end;
      }
      if (end > x) {
        const auto at = [&](std::size_t column, std::size_t row) -> Eigen::Vector2d {
          return corner + cell_m * Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row));
        };
        black.push_back({at(x, y), at(end, y + 1)});
      }
      x = end + 1;
    }
  }
  return !bits.empty();
}

// The squares that touch a tag's corners.
void add_corner_squares(const Target& target, const Marker& marker, std::vector<BlackRectangle>& black) {
  const Eigen::Vector2d middle = (marker.corners_m[0].head<2>() + marker.corners_m[2].head<2>()) / 2;
  for (const Eigen::Vector3d& point : marker.corners_m) {
    const Eigen::Vector2d near_m = point.head<2>();
    const Eigen::Vector2d far_m = near_m + target.marker_m * (near_m - middle).cwiseSign();
    black.push_back({near_m.cwiseMin(far_m), near_m.cwiseMax(far_m)});
  }
}

}  // namespace

Result<std::vector<BlackRectangle>> black_rectangles(const Target& target) {
  std::vector<BlackRectangle> black;
  if (target.kind != TargetKind::kAprilGrid) {
    add_squares(target, black);
  }
  if (target.kind == TargetKind::kCharuco) {
    if (const Result<int> known = dictionary_number(target.dictionary); !known) {
      return Unexpected(known.error());
    }
  }
  for (const Marker& marker : target.markers) {
    if (!add_marker(target, marker, black)) {
      return fail(ErrorCode::kInvalidArgument, target.dictionary + " has no marker " + std::to_string(marker.id) +
                                                   "; choose a larger dictionary or a smaller target");
    }
    if (target.kind == TargetKind::kAprilGrid) {
      add_corner_squares(target, marker, black);
    }
  }
  return black;
}

Result<std::string> target_svg(const Target& target) {
  const auto black = black_rectangles(target);
  if (!black) {
    return Unexpected(black.error());
  }
  Eigen::Vector2d low = black->front().from_m;
  Eigen::Vector2d high = black->front().to_m;
  for (const BlackRectangle& each : *black) {
    low = low.cwiseMin(each.from_m);
    high = high.cwiseMax(each.to_m);
  }
  constexpr double kMargin_m = 0.01;
  constexpr double kMillimetres = 1e3;
  low -= Eigen::Vector2d::Constant(kMargin_m);
  const Eigen::Vector2d size = kMillimetres * (high + Eigen::Vector2d::Constant(kMargin_m) - low);
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(),
                "%s%.3fmm\" height=\"%.3fmm\" viewBox=\"0 0 %.3f %.3f\">\n"
                "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
                kSvgBegin, size.x(), size.y(), size.x(), size.y());
  std::string svg = line.data();
  for (const BlackRectangle& each : *black) {
    const Eigen::Vector2d from = kMillimetres * (each.from_m - low);
    const Eigen::Vector2d extent = kMillimetres * (each.to_m - each.from_m);
    std::snprintf(line.data(), line.size(), "<rect x=\"%.4f\" y=\"%.4f\" width=\"%.4f\" height=\"%.4f\"/>\n", from.x(),
                  from.y(), extent.x(), extent.y());
    svg += line.data();
  }
  return svg + "</svg>\n";
}

bool is_target_svg(const std::filesystem::path& path) {
  return begins_with(path, kSvgBegin);
}

}  // namespace kinetrace::calibration
