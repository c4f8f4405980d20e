// Names of image files with numbers or times, one a line; '<' marks names of the left view alone, '>' of the right one.
#include <filesystem>
#include <fstream>
#include <set>

#include "fuzz_target.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "memory_folder.hpp"
#include "small_image.hpp"
#include "util/text_file.hpp"

namespace {

constexpr const char* kCalibration =
    "image_width: 48\nimage_height: 32\nK1: [40, 0, 24, 0, 40, 16, 0, 0, 1]\nD1: [0, 0, 0, 0]\n"
    "K2: [40, 0, 24, 0, 40, 16, 0, 0, 1]\nD2: [0, 0, 0, 0]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.5, 0, 0]\n";

/// Links to one image, so that a name costs one system call.
void fill(const std::filesystem::path& folder, const std::set<std::string>& names, const std::string& image) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  for (const std::string& name : names) {
    std::error_code ignored;
    std::filesystem::create_hard_link(image, folder / name, ignored);
  }
}

}  // namespace

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put("stereo.yaml", kCalibration);
  static const std::string image = folder.put("image", small_image());
  constexpr std::size_t kMaxNames = 12;
  constexpr std::size_t kMaxLength = 100;
  std::set<std::string> left;
  std::set<std::string> right;
  for (std::string_view line : hal::content_lines(input)) {
    const bool only_left = line.front() == '<';
    const bool only_right = line.front() == '>';
    line.remove_prefix(only_left || only_right ? 1 : 0);
    if (line.size() > kMaxLength || line.find('/') != std::string_view::npos ||
        line.find('\0') != std::string_view::npos || left.size() + right.size() >= kMaxNames) {
      continue;
    }
    if (!only_right) {
      left.insert(std::string(line) + ".pgm");
    }
    if (!only_left) {
      right.insert(std::string(line) + ".pgm");
    }
  }
  fill(folder.path() / "left", left, image);
  fill(folder.path() / "right", right, image);
  static_cast<void>(hal::open_dataset({.layout = hal::DatasetLayout::kFolder, .path = folder.path()}));
}
