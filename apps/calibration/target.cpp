#include "target.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <yaml-cpp/yaml.h>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/yaml_text.hpp"

namespace kinetrace::calibration {
namespace {

constexpr const char* kExpected =
    "; expected chessboard:9x6:0.03 (inner corners, metres), charuco:8x6:0.04:0.03:DICT_4X4_100, "
    "aprilgrid:6x6:0.088:0.3, or a target file";
constexpr int kMaxSide = 100;
constexpr double kMinLength_m = 1e-4;
constexpr double kMaxLength_m = 10.0;
constexpr int kMinPoints = 3;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

template <typename Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

struct Size {
  int columns = 0;
  int rows = 0;
};

Result<Size> check_size(int columns, int rows, int least) {
  if (columns < least || rows < least || columns > kMaxSide || rows > kMaxSide) {
    return fail(ErrorCode::kInvalidArgument, "a target of " + std::to_string(columns) + "x" + std::to_string(rows) +
                                                 " is not within " + std::to_string(least) + "x" +
                                                 std::to_string(least) + " and 100x100");
  }
  return Size{columns, rows};
}

Result<Size> size_in(std::string_view text, int least) {
  const auto parts = split(text, 'x');
  const auto columns = number_in<int>(parts.front());
  const auto rows = number_in<int>(parts.back());
  if (parts.size() != 2 || !columns || !rows) {
    return fail(ErrorCode::kInvalidArgument, "'" + std::string(text) + "' is no size" + kExpected);
  }
  return check_size(*columns, *rows, least);
}

Result<double> check_length(double length_m) {
  if (!std::isfinite(length_m) || length_m < kMinLength_m || length_m > kMaxLength_m) {
    return fail(ErrorCode::kInvalidArgument,
                "a length of " + std::to_string(length_m) + " m is none of a target; give it in metres");
  }
  return length_m;
}

Result<double> length_in(std::string_view text) {
  const auto length_m = number_in<double>(text);
  if (!length_m) {
    return fail(ErrorCode::kInvalidArgument, "'" + std::string(text) + "' is no length" + kExpected);
  }
  return check_length(*length_m);
}

Unexpected<Error> malformed(std::string_view text) {
  return fail(ErrorCode::kInvalidArgument, "target '" + std::string(text) + "' is not understood" + kExpected);
}

Result<Target> parse_chessboard(std::string_view text, const std::vector<std::string_view>& parts) {
  if (parts.size() != 3) {
    return malformed(text);
  }
  const auto size = size_in(parts[1], kMinPoints);
  const auto square_m = length_in(parts[2]);
  if (!size || !square_m) {
    return Unexpected(size ? square_m.error() : size.error());
  }
  return chessboard_target(size->columns, size->rows, *square_m);
}

Result<Target> make_charuco(const Size& size, double square_m, double marker_m, std::string dictionary, bool legacy) {
  if (marker_m >= square_m) {
    return fail(ErrorCode::kInvalidArgument, "a marker of " + std::to_string(marker_m) +
                                                 " m does not fit into a square of " + std::to_string(square_m) + " m");
  }
  return charuco_target(size.columns, size.rows, square_m, marker_m, std::move(dictionary), legacy);
}

Result<Target> parse_charuco(std::string_view text, std::vector<std::string_view> parts) {
  const bool legacy = parts.back() == "legacy";
  if (legacy) {
    parts.pop_back();
  }
  if (parts.size() != 4 && parts.size() != 5) {
    return malformed(text);
  }
  const auto size = size_in(parts[1], kMinPoints);
  const auto square_m = length_in(parts[2]);
  const auto marker_m = length_in(parts[3]);
  if (!size || !square_m || !marker_m) {
    return Unexpected(!size ? size.error() : !square_m ? square_m.error() : marker_m.error());
  }
  return make_charuco(*size, *square_m, *marker_m, parts.size() == 5 ? std::string(parts[4]) : "DICT_4X4_100", legacy);
}

Result<Target> parse_april_grid(std::string_view text, const std::vector<std::string_view>& parts) {
  const bool has_border = parts.size() == 5;
  const auto border_bits = has_border ? number_in<int>(parts[4]) : std::optional(2);
  if ((parts.size() != 4 && !has_border) || !border_bits || *border_bits < 1 || *border_bits > 2) {
    return malformed(text);
  }
  const auto size = size_in(parts[1], 2);
  const auto tag_m = length_in(parts[2]);
  const auto gap = length_in(parts[3]);
  if (!size || !tag_m || !gap) {
    return Unexpected(!size ? size.error() : !tag_m ? tag_m.error() : gap.error());
  }
  return april_grid_target(size->columns, size->rows, *tag_m, *gap, *border_bits);
}

std::string metres(double length_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g m", length_m);
  return text.data();
}

// yaml-cpp keeps duplicates and finds only the first: the second would be ignored silently.
Status check_keys(const YAML::Node& file) {
  if (!file.IsMap()) {
    return fail(ErrorCode::kBadFormat,
                "is no target file; it says target_type: aprilgrid, checkerboard or charuco and its sizes");
  }
  std::map<std::string, int> line_of;
  for (const auto& entry : file) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : std::string();
    const int line = entry.first.Mark().line + 1;
    if (const auto [first, is_new] = line_of.emplace(key, line); !is_new) {
      return fail(ErrorCode::kBadFormat, "line " + std::to_string(line) + ": \"" + key +
                                             "\" is already given in line " + std::to_string(first->second) +
                                             "; keep one");
    }
  }
  return {};
}

// Values of a target file; missing or invalid ones throw as in yaml-cpp.
Result<Target> target_of(const YAML::Node& file) {
  const auto type = file["target_type"].as<std::string>();
  const auto integer = [&file](const char* key) { return file[key].as<int>(); };
  const auto length = [&file](const char* key) { return check_length(file[key].as<double>()); };
  if (type == "aprilgrid") {
    const auto size = check_size(integer("tagCols"), integer("tagRows"), 2);
    const auto tag_m = length("tagSize");
    const auto gap = length("tagSpacing");
    const int border_bits = file["borderBits"] ? integer("borderBits") : 2;
    if (!size || !tag_m || !gap) {
      return Unexpected(!size ? size.error() : !tag_m ? tag_m.error() : gap.error());
    }
    if (border_bits < 1 || border_bits > 2) {
      return fail(ErrorCode::kBadFormat,
                  "borderBits is " + std::to_string(border_bits) + "; a tag's border has 1 or 2");
    }
    return april_grid_target(size->columns, size->rows, *tag_m, *gap, border_bits);
  }
  if (type == "checkerboard") {
    const auto size = check_size(integer("targetCols"), integer("targetRows"), kMinPoints);
    const auto square_m = length("colSpacingMeters");
    const auto row_m = length("rowSpacingMeters");
    if (!size || !square_m || !row_m) {
      return Unexpected(!size ? size.error() : !square_m ? square_m.error() : row_m.error());
    }
    if (*square_m != *row_m) {
      return fail(ErrorCode::kInvalidArgument, "squares that are not square are not supported");
    }
    return chessboard_target(size->columns, size->rows, *square_m);
  }
  if (type == "charuco") {
    const auto size = check_size(integer("squaresX"), integer("squaresY"), kMinPoints);
    const auto square_m = length("squareLength");
    const auto marker_m = length("markerLength");
    if (!size || !square_m || !marker_m) {
      return Unexpected(!size ? size.error() : !square_m ? square_m.error() : marker_m.error());
    }
    return make_charuco(*size, *square_m, *marker_m, file["dictionary"].as<std::string>("DICT_4X4_100"),
                        file["legacyPattern"].as<bool>(false));
  }
  return fail(ErrorCode::kInvalidArgument, "target_type is '" + type + "'; use aprilgrid, checkerboard or charuco");
}

}  // namespace

Eigen::Vector2d Target::extent_m() const {
  Eigen::Vector2d low = points_m.front().head<2>();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector3d& point : points_m) {
    low = low.cwiseMin(point.head<2>());
    high = high.cwiseMax(point.head<2>());
  }
  return high - low;
}

std::string Target::description() const {
  std::string size = std::to_string(columns) + "x" + std::to_string(rows);
  switch (kind) {
    case TargetKind::kChessboard: return "chessboard " + size + ", squares of " + metres(square_m);
    case TargetKind::kCharuco:
      return "ChArUco board " + size + ", squares of " + metres(square_m) + ", markers of " + metres(marker_m) + " (" +
             dictionary + ")";
    case TargetKind::kAprilGrid:
      return "AprilTag grid " + size + ", tags of " + metres(square_m) + ", gaps of " + metres(marker_m);
  }
  return size;
}

Target chessboard_target(int columns, int rows, double square_m) {
  Target target{.kind = TargetKind::kChessboard, .columns = columns, .rows = rows, .square_m = square_m};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      target.points_m.emplace_back(column * square_m, row * square_m, 0.0);
    }
  }
  return target;
}

Target charuco_target(int columns, int rows, double square_m, double marker_m, std::string dictionary, bool legacy) {
  Target target = chessboard_target(columns - 1, rows - 1, square_m);
  target.kind = TargetKind::kCharuco;
  target.columns = columns;
  target.rows = rows;
  target.marker_m = marker_m;
  target.dictionary = std::move(dictionary);
  // The first inner corner is the origin: the top left square begins one square before it. That square is black, except
  // on old boards with an even number of rows.
  const int first_white = legacy && rows % 2 == 0 ? 0 : 1;
  const double inset_m = (square_m - marker_m) / 2;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if ((row + column) % 2 != first_white) {
        continue;
      }
      const Eigen::Vector3d corner((column - 1) * square_m + inset_m, (row - 1) * square_m + inset_m, 0.0);
      const Eigen::Vector3d right(marker_m, 0.0, 0.0);
      const Eigen::Vector3d down(0.0, marker_m, 0.0);
      target.markers.push_back(
          {static_cast<int>(target.markers.size()), {corner, corner + right, corner + right + down, corner + down}});
    }
  }
  return target;
}

Target april_grid_target(int columns, int rows, double tag_m, double gap_ratio, int border_bits) {
  Target target{.kind = TargetKind::kAprilGrid,
                .columns = columns,
                .rows = rows,
                .square_m = tag_m,
                .marker_m = tag_m * gap_ratio,
                .dictionary = "tag36h11",
                .border_bits = border_bits};
  const double pitch_m = tag_m * (1.0 + gap_ratio);
  // Kalibr numbers tags from the bottom left one, row by row upwards.
  for (int id = 0; id < rows * columns; ++id) {
    const int row = rows - 1 - id / columns;
    const Eigen::Vector3d corner((id % columns) * pitch_m, row * pitch_m, 0.0);
    const Eigen::Vector3d right(tag_m, 0.0, 0.0);
    const Eigen::Vector3d down(0.0, tag_m, 0.0);
    const Marker marker{id, {corner, corner + right, corner + right + down, corner + down}};
    target.points_m.insert(target.points_m.end(), marker.corners_m.begin(), marker.corners_m.end());
    target.markers.push_back(marker);
  }
  return target;
}

Result<Target> parse_target(std::string_view text) {
  const auto parts = split(text, ':');
  if (parts.front() == "chessboard") {
    return parse_chessboard(text, parts);
  }
  if (parts.front() == "charuco") {
    return parse_charuco(text, parts);
  }
  if (parts.front() == "aprilgrid") {
    return parse_april_grid(text, parts);
  }
  std::error_code error;
  if (!std::filesystem::exists(text, error)) {
    return malformed(text);
  }
  return read_target(std::string(text));
}

Result<Target> read_target(const std::string& path) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
  const auto text = InputFile::read_whole(path, kMaxBytes);
  if (!text) {
    return Unexpected(text.error());
  }
  if (const auto line = second_document_line(*text)) {
    return fail(ErrorCode::kBadFormat, path + ": line " + std::to_string(*line) + ": " + std::string(kSecondDocument));
  }
  try {
    const YAML::Node file = YAML::Load(*text);
    const Status keys = check_keys(file);
    Result<Target> target = keys ? target_of(file) : Unexpected(keys.error());
    return target ? target : fail(ErrorCode::kBadFormat, path + ": " + target.error().message);
  } catch (const YAML::Exception& exception) {
    return fail(ErrorCode::kBadFormat, path + ": is no target file (" + exception.what() +
                                           "); it says target_type: aprilgrid, checkerboard or charuco and its sizes");
  }
}

}  // namespace kinetrace::calibration
