// The calibration board: its points and their positions.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"

namespace kinetrace::calibration {

enum class TargetKind : std::uint8_t {
  kChessboard,  ///< Plain squares; must be completely visible.
  kCharuco,     ///< A chessboard with ArUco markers in its white squares; may be partly visible.
  kAprilGrid,   ///< AprilTags in rows and columns, black squares at their corners, as Kalibr prints them.
};

/// A square marker: its number and its corners, clockwise from the top left one as printed.
struct Marker {
  int id = 0;
  std::array<Eigen::Vector3d, 4> corners_m;
};

/// Points in the board's own frame: x right, y down, z = 0 on the paper, metres.
struct Target {
  TargetKind kind = TargetKind::kChessboard;
  int columns = 0;  ///< Chessboard: inner corners; ChArUco: squares; AprilTag grid: tags.
  int rows = 0;
  double square_m = 0.0;                       ///< Side of a square, or of a tag's black border.
  double marker_m = 0.0;                       ///< ChArUco: side of a marker. AprilTag grid: gap between tags.
  std::string dictionary = {};                 ///< Of the markers: "DICT_6X6_250", "tag36h11".
  int border_bits = 1;                         ///< Width of a tag's black border.
  std::vector<Eigen::Vector3d> points_m = {};  ///< By the id of a corner.
  std::vector<Marker> markers = {};            ///< None of a plain chessboard.

  /// From the first to the last point in each direction.
  [[nodiscard]] Eigen::Vector2d extent_m() const;
  /// "chessboard 9x6, squares of 0.03 m".
  [[nodiscard]] std::string description() const;
};

/// From "chessboard:9x6:0.03" (inner corners, side of a square), "charuco:8x6:0.04:0.03:DICT_5X5_100" (squares, side of
/// a square, of a marker, dictionary; "DICT_4X4_100" if it is left out; ":legacy" at the end for boards of OpenCV
/// before 4.6 with an even number of rows), "aprilgrid:6x6:0.088:0.3" (tags, side of a tag, gap between tags as part of
/// that;
/// ":1" at the end for tags with a border one bit wide instead of Kalibr's two), or the name of a file, see
/// read_target. Lengths are in metres. Errors: kInvalidArgument with what was expected; those of read_target.
[[nodiscard]] Result<Target> parse_target(std::string_view text);

/// A target file in YAML as Kalibr has them (target_type aprilgrid or checkerboard), and target_type: charuco with
/// squaresX, squaresY, squareLength, markerLength and dictionary. Errors: kNotFound, kIo, kBadFormat.
[[nodiscard]] Result<Target> read_target(const std::string& path);

// Targets from numbers that have been checked.
[[nodiscard]] Target chessboard_target(int columns, int rows, double square_m);
[[nodiscard]] Target charuco_target(int columns, int rows, double square_m, double marker_m, std::string dictionary,
                                    bool legacy = false);
[[nodiscard]] Target april_grid_target(int columns, int rows, double tag_m, double gap_ratio, int border_bits = 2);

}  // namespace kinetrace::calibration
