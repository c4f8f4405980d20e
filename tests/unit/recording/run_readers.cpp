#include "run_readers.hpp"

#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace kinetrace::recording {
namespace {

void require(bool condition, const std::string& what) {
  if (!condition) {
    throw std::runtime_error(what);
  }
}

template <typename Value>
Value parse(const std::string& text) {
  Value value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  require(error == std::errc{} && end == text.data() + text.size(), "not a number: '" + text + "'");
  return value;
}

Se3 pose_from(double qx, double qy, double qz, double qw, const Eigen::Vector3d& translation) {
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  require(std::abs(q.norm() - 1.0) < 1e-6, "not a unit quaternion");
  return {q.normalized().toRotationMatrix(), translation};
}

std::vector<std::string> data_lines(const std::filesystem::path& path) {
  std::vector<std::string> lines = read_lines(path);
  std::erase_if(lines, [](const std::string& line) { return line.starts_with('#'); });
  return lines;
}

template <typename Value>
Value take(const std::string& data, std::size_t& offset) {
  require(offset + sizeof(Value) <= data.size(), "PLY data too short");
  Value value;
  std::memcpy(&value, data.data() + offset, sizeof(Value));
  offset += sizeof(Value);
  return value;
}

ColmapImage parse_image(const std::vector<std::string>& head, const std::string& observations) {
  require(head.size() == 10 && head[8] == "1", "image line");
  ColmapImage image;
  image.T_cam_body = pose_from(to_double(head[2]), to_double(head[3]), to_double(head[4]), to_double(head[1]),
                               {to_double(head[5]), to_double(head[6]), to_double(head[7])});
  image.name = head[9];
  const std::vector<std::string> fields = split(observations, ' ');
  require(fields.size() % 3 == 0, "observations line");
  for (std::size_t i = 0; i < fields.size(); i += 3) {
    image.points_px.emplace_back(to_double(fields[i]), to_double(fields[i + 1]));
    image.point_ids.push_back(to_integer(fields[i + 2]));
  }
  return image;
}

void check_references(const ColmapModel& model) {
  std::size_t referred = 0;
  for (const auto& [id, point] : model.points) {
    require(point.track.size() >= 2, "track of point " + std::to_string(id));
    for (const auto& [image_id, index] : point.track) {
      require(model.images.contains(image_id), "image " + std::to_string(image_id) + " does not exist");
      require(model.images.at(image_id).point_ids.at(index) == id, "track of point " + std::to_string(id));
    }
    referred += point.track.size();
  }
  std::size_t referring = 0;
  for (const auto& [image_id, image] : model.images) {
    for (const std::int64_t id : image.point_ids) {
      require(id == -1 || model.points.contains(id), "point " + std::to_string(id) + " does not exist");
      referring += id == -1 ? 0 : 1;
    }
  }
  require(referred == referring, "observations missing from tracks");
}

}  // namespace

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.is_open(), "cannot open " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> read_lines(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  require(text.empty() || text.back() == '\n', path.string() + " ends within a line");
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::vector<std::string> split(std::string_view line, char separator) {
  std::vector<std::string> fields;
  while (!line.empty()) {
    const std::size_t end = line.find(separator);
    fields.emplace_back(line.substr(0, end));
    require(!fields.back().empty(), "empty field");
    line = end == std::string_view::npos ? std::string_view{} : line.substr(end + 1);
  }
  return fields;
}

double to_double(const std::string& text) {
  return parse<double>(text);
}
std::int64_t to_integer(const std::string& text) {
  return parse<std::int64_t>(text);
}

std::vector<TumRow> read_tum(const std::filesystem::path& path) {
  std::vector<TumRow> rows;
  for (const std::string& line : read_lines(path)) {
    const std::vector<std::string> f = split(line, ' ');
    require(f.size() == 8, "TUM line");
    rows.push_back({f[0], pose_from(to_double(f[4]), to_double(f[5]), to_double(f[6]), to_double(f[7]),
                                    {to_double(f[1]), to_double(f[2]), to_double(f[3])})});
  }
  return rows;
}

std::vector<std::map<std::string, std::string>> read_csv(const std::filesystem::path& path) {
  const std::vector<std::string> lines = read_lines(path);
  require(!lines.empty(), "no header");
  const std::vector<std::string> names = split(lines[0], ',');
  std::vector<std::map<std::string, std::string>> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> fields = split(lines[i], ',');
    require(fields.size() == names.size(), "CSV line " + std::to_string(i));
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (std::size_t k = 0; k < names.size(); ++k) {
      row[names[k]] = fields[k];
    }
  }
  return rows;
}

PlyFile read_ply(const std::filesystem::path& path) {
  const std::string data = read_text(path);
  const std::string end = "end_header\n";
  std::size_t offset = data.find(end);
  require(offset != std::string::npos, "no PLY header");
  const std::string header = data.substr(0, offset);
  offset += end.size();
  const std::string begin = "ply\nformat binary_little_endian 1.0\ncomment ";
  require(header.starts_with(begin), "PLY header begins differently");
  const std::size_t comment_end = header.find('\n', begin.size());
  PlyFile ply{.comment = header.substr(begin.size(), comment_end - begin.size()), .vertices = {}};
  const std::string element = "element vertex ";
  require(header.compare(comment_end + 1, element.size(), element) == 0, "PLY element");
  const std::size_t number = comment_end + 1 + element.size();
  const std::size_t number_end = header.find('\n', number);
  const std::int64_t count = to_integer(header.substr(number, number_end - number));
  require(header.substr(number_end + 1) ==
              "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
              "property uchar blue\nproperty int frame\nproperty uint point_id\n",
          "PLY properties");
  for (std::int64_t i = 0; i < count; ++i) {
    PlyVertex& vertex = ply.vertices.emplace_back();
    for (int k = 0; k < 3; ++k) {
      vertex.position_m[k] = take<float>(data, offset);
    }
    for (std::uint8_t& channel : vertex.rgb) {
      channel = take<std::uint8_t>(data, offset);
    }
    vertex.frame = take<std::int32_t>(data, offset);
    vertex.point_id = take<std::uint32_t>(data, offset);
  }
  require(offset == data.size(), "PLY data too long");
  return ply;
}

ColmapModel read_colmap(const std::filesystem::path& directory) {
  ColmapModel model;
  const std::vector<std::string> cameras = data_lines(directory / "cameras.txt");
  require(cameras.size() == 1, "one camera");
  const std::vector<std::string> camera = split(cameras[0], ' ');
  require(camera.size() == 8 && camera[0] == "1" && camera[1] == "PINHOLE", "camera line");
  for (std::size_t i = 0; i < model.camera.size(); ++i) {
    model.camera[i] = to_double(camera[i + 2]);
  }
  const std::vector<std::string> images = data_lines(directory / "images.txt");
  require(images.size() % 2 == 0, "two lines per image");
  for (std::size_t i = 0; i < images.size(); i += 2) {
    const std::vector<std::string> head = split(images[i], ' ');
    const bool is_new = model.images.emplace(to_integer(head.at(0)), parse_image(head, images[i + 1])).second;
    require(is_new, "image id twice");
  }
  for (const std::string& line : data_lines(directory / "points3D.txt")) {
    const std::vector<std::string> f = split(line, ' ');
    require(f.size() >= 8 && f.size() % 2 == 0 && f[4] == f[5] && f[5] == f[6], "point line");
    ColmapPoint point{.position_m = {to_double(f[1]), to_double(f[2]), to_double(f[3])},
                      .gray = static_cast<int>(to_integer(f[4])),
                      .error_px = to_double(f[7]),
                      .track = {}};
    for (std::size_t i = 8; i < f.size(); i += 2) {
      point.track.emplace_back(to_integer(f[i]), static_cast<std::size_t>(to_integer(f[i + 1])));
    }
    require(model.points.emplace(to_integer(f[0]), std::move(point)).second, "point id twice");
  }
  check_references(model);
  return model;
}

}  // namespace kinetrace::recording
