#include "figure/figure_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace::figure {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY values are copied as they are");

constexpr int kAbsent = -1;

/// Offsets of the used values in a vertex.
struct VertexLayout {
  std::size_t count = 0;
  int bytes = 0;
  std::array<int, 3> position{kAbsent, kAbsent, kAbsent};
  int red = kAbsent;
};

int bytes_of(std::string_view type) {
  constexpr std::array<std::pair<std::string_view, int>, 14> kTypes{{{"char", 1},
                                                                     {"uchar", 1},
                                                                     {"int8", 1},
                                                                     {"uint8", 1},
                                                                     {"short", 2},
                                                                     {"ushort", 2},
                                                                     {"int16", 2},
                                                                     {"uint16", 2},
                                                                     {"int", 4},
                                                                     {"uint", 4},
                                                                     {"int32", 4},
                                                                     {"uint32", 4},
                                                                     {"float", 4},
                                                                     {"float32", 4}}};
  for (const auto& [name, bytes] : kTypes) {
    if (name == type) {
      return bytes;
    }
  }
  return type == "double" || type == "float64" ? 8 : 0;
}

Unexpected<Error> damaged(const std::filesystem::path& path, const std::string& reason) {
  return fail(ErrorCode::kBadFormat, path.string() + ": " + reason + "; expected a point cloud of a run folder");
}

bool add_property(std::istringstream& words, VertexLayout& layout) {
  std::string type;
  std::string name;
  words >> type >> name;
  const int bytes = bytes_of(type);
  if (bytes == 0 || name.empty()) {
    return false;
  }
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    if (name == kAxes[axis] && (type == "float" || type == "float32")) {
      layout.position[axis] = layout.bytes;
    }
  }
  if (name == "red" && bytes == 1) {
    layout.red = layout.bytes;
  }
  layout.bytes += bytes;
  return true;
}

/// False at the end of the file and beyond the length of any header.
bool next_line(std::ifstream& file, std::string& line) {
  std::array<char, 256> characters{};
  file.getline(characters.data(), characters.size());
  line = characters.data();
  constexpr std::streamoff kMaxHeader = 1 << 16;
  return file.good() && file.tellg() < kMaxHeader;
}

Result<VertexLayout> read_header(std::ifstream& file, const std::filesystem::path& path) {
  VertexLayout layout;
  std::string line;
  if (!next_line(file, line) || line != "ply") {
    return damaged(path, "is not a PLY file");
  }
  bool is_binary = false;
  int elements = 0;
  while (next_line(file, line) && line != "end_header") {
    std::istringstream words(line);
    std::string keyword;
    words >> keyword;
    if (keyword == "format") {
      is_binary = line.starts_with("format binary_little_endian");
    } else if (keyword == "element") {
      std::string name;
      words >> name >> layout.count;
      // Data behind the vertices is ignored.
      if (++elements == 1 && (name != "vertex" || !words)) {
        return damaged(path, "does not begin with vertices");
      }
    } else if (keyword == "property" && elements == 1 && !add_property(words, layout)) {
      return damaged(path, "has a property that cannot be read: " + line);
    }
    if (elements > 1) {
      return damaged(path, "holds more than vertices");
    }
  }
  if (!is_binary || !file || std::count(layout.position.begin(), layout.position.end(), kAbsent) > 0) {
    return damaged(path, "is not binary little-endian with float x, y, z");
  }
  return layout;
}

}  // namespace

Result<Cloud> read_cloud(const std::filesystem::path& path, std::size_t most) {
  if (const Result<InputFile> usable = InputFile::open(path.c_str()); !usable) {
    return Unexpected(usable.error());
  }
  std::ifstream file(path, std::ios::binary);
  const Result<VertexLayout> layout = read_header(file, path);
  if (!layout) {
    return Unexpected(layout.error());
  }
  const std::streamoff begin = file.tellg();
  file.seekg(0, std::ios::end);
  const std::streamoff bytes = static_cast<std::streamoff>(file.tellg()) - begin;
  const auto stored = static_cast<std::size_t>(bytes) / static_cast<std::size_t>(layout->bytes);
  if (stored < layout->count) {
    return damaged(path, "ends after " + std::to_string(stored) + " of " + std::to_string(layout->count) + " vertices");
  }
  Cloud cloud;
  cloud.every = std::max<std::size_t>(1, (layout->count + most - 1) / std::max<std::size_t>(most, 1));
  cloud.points.reserve(layout->count / cloud.every + 1);
  std::vector<char> vertex(static_cast<std::size_t>(layout->bytes));
  for (std::size_t i = 0; i < layout->count; i += cloud.every) {
    file.seekg(begin + static_cast<std::streamoff>(i) * layout->bytes);
    file.read(vertex.data(), layout->bytes);
    CloudPoint point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::memcpy(&point.position_m[static_cast<Eigen::Index>(axis)], vertex.data() + layout->position[axis],
                  sizeof(float));
    }
    constexpr std::uint8_t kMiddleGray = 128;
    if (!file) {
      return fail(ErrorCode::kIo, path.string() + ": cannot be read; check the disk");
    }
    point.gray =
        layout->red == kAbsent ? kMiddleGray : static_cast<std::uint8_t>(vertex[static_cast<std::size_t>(layout->red)]);
    if (point.position_m.allFinite()) {
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

}  // namespace kinetrace::figure
