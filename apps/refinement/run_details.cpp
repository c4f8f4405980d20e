#include "run_details.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <sstream>

namespace kinetrace::batch {

std::map<std::int64_t, std::string> image_names(const recording::Run& run) {
  std::map<std::int64_t, std::string> names;
  std::ifstream file(run.directory / "colmap" / "background" / "images.txt");
  std::string line;
  bool is_image = true;  // Each image has two lines: its pose and its points.
  while (std::getline(file, line)) {
    if (line.starts_with("#")) {
      continue;
    }
    std::istringstream fields(line);
    std::int64_t id = 0;
    std::string skipped;
    std::string name;
    if (is_image && fields >> id) {
      for (int i = 0; i < 8; ++i) {
        fields >> skipped;
      }
      fields >> name;
      names[id - 1] = name.substr(0, name.rfind('.'));
    }
    is_image = !is_image;
  }
  return names;
}

std::map<std::uint32_t, std::uint8_t> point_intensities(const recording::Run& run, std::uint32_t track_id) {
  const std::string name = track_id == 0 ? "background.ply" : "object_" + std::to_string(track_id) + "_model.ply";
  std::map<std::uint32_t, std::uint8_t> intensities;
  std::ifstream file(run.directory / "points" / name, std::ios::binary);
  std::string line;
  while (std::getline(file, line) && line != "end_header") {
  }
  constexpr std::size_t kGrayAt = 12;  // After x y z: red, green, blue, frame, point_id.
  constexpr std::size_t kIdAt = 19;
  std::array<char, 23> vertex{};
  while (file.read(vertex.data(), vertex.size())) {
    std::uint32_t id = 0;
    std::memcpy(&id, vertex.data() + kIdAt, sizeof id);
    intensities[id] = static_cast<std::uint8_t>(vertex[kGrayAt]);
  }
  return intensities;
}

}  // namespace kinetrace::batch
