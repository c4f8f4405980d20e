#include "recording_for_test.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::hal::test {
namespace {

void make_parent(const std::string& path) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
}

std::string six_digits(int i) {
  std::string digits = std::to_string(i);
  return std::string(6 - digits.size(), '0') + digits;
}

}  // namespace

void write_text(const std::string& path, const std::string& text) {
  make_parent(path);
  std::ofstream(path, std::ios::binary) << text;
}

void write_image(const std::string& path, std::uint8_t value, int width, int height) {
  make_parent(path);
  const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width * height), value);
  if (!imaging::write_png_gray8(path.c_str(), {pixels.data(), width, height, width})) {
    throw std::runtime_error("cannot write " + path);
  }
}

void write_image16(const std::string& path, std::uint16_t value, int width, int height) {
  make_parent(path);
  const std::vector<std::uint16_t> pixels(static_cast<std::size_t>(width * height), value);
  if (!imaging::write_png_gray16(path.c_str(), {pixels.data(), width, height, width})) {
    throw std::runtime_error("cannot write " + path);
  }
}

void write_cut_image(const std::string& path, std::size_t bytes) {
  write_image(path, 1);
  std::filesystem::resize_file(path, bytes);
}

void write_color_image(const std::string& path, std::uint8_t value, int width, int height) {
  make_parent(path);
  const std::vector<imaging::Rgb8> pixels(static_cast<std::size_t>(width * height), {value, value, value});
  if (!imaging::write_png_rgb8(path.c_str(), {pixels.data(), width, height, width})) {
    throw std::runtime_error("cannot write " + path);
  }
}

std::string kitti_projections() {
  const auto line = [](const char* key, const char* offset) {
    return std::string(key) + ": 40 0 24 " + offset + " 0 40 16 0 0 0 1 0\n";
  };
  return line("P0", "0") + line("P1", "-20") + line("P2", "2.4") + line("P3", "-18.8");
}

Recording::Recording(int count) {
  std::string times;
  for (int i = 0; i < count; ++i) {
    write_image(left(i), static_cast<std::uint8_t>(i));
    write_image(right(i), static_cast<std::uint8_t>(100 + i));
    times += std::to_string(i) + "e-1\n";
  }
  write_text((path_ / "calib.txt").string(), kitti_projections());
  write_text((path_ / "times.txt").string(), times);
}

std::string Recording::left(int i) const {
  return (path_ / "image_0" / (six_digits(i) + ".png")).string();
}
std::string Recording::right(int i) const {
  return (path_ / "image_1" / (six_digits(i) + ".png")).string();
}
Result<Dataset> Recording::open() const {
  return open_dataset({.layout = DatasetLayout::kKittiOdometry, .path = path_});
}

}  // namespace kinetrace::hal::test
