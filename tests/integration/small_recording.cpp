#include "small_recording.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::test {
namespace {

constexpr double kUpperDepth = 15.0;  // Disparity 10 px.
constexpr double kLowerDepth = 7.5;   // Disparity 20 px.

// A number in [0, 1) for each grid point.
double noise(int x, int y, int wall) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
           static_cast<std::uint32_t>(wall) * 0xC2B2AE3DU;
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12)) * 0x297A2D39U;
  return static_cast<double>(h ^ (h >> 15)) / 4294967296.0;
}

// Smooth texture with details of a few pixels.
double texture(double x, double y, int wall) {
  constexpr double kCell = 6.0;
  const double gx = x / kCell;
  const double gy = y / kCell;
  const int x0 = static_cast<int>(std::floor(gx));
  const int y0 = static_cast<int>(std::floor(gy));
  const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double ax = ease(gx - x0);
  const double ay = ease(gy - y0);
  const double top = noise(x0, y0, wall) * (1.0 - ax) + noise(x0 + 1, y0, wall) * ax;
  const double bottom = noise(x0, y0 + 1, wall) * (1.0 - ax) + noise(x0 + 1, y0 + 1, wall) * ax;
  return top * (1.0 - ay) + bottom * ay;
}

std::vector<std::uint8_t> render(int width, int height, double view_x_m, const SmallRecording& look) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), look.brightness);
  for (int y = 0; y < height && !look.uniform; ++y) {
    const int wall = y < height / 2 ? 0 : 1;
    const double depth = wall == 0 ? kUpperDepth : kLowerDepth;
    const double shift = SmallRecording::kFocal * view_x_m / depth;
    for (int x = 0; x < width; ++x) {
      const double value = 20.0 + 215.0 * texture(x + shift, y, wall);
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(value);
    }
  }
  return pixels;
}

void write_png(const std::filesystem::path& path, const std::vector<std::uint8_t>& pixels, int width, int height) {
  if (!imaging::write_png_gray8(path.c_str(), GrayView{pixels.data(), width, height, width})) {
    throw std::runtime_error("cannot write " + path.string());
  }
}

// The checksum of PNG chunks (ISO/IEC 15948, annex D).
std::uint32_t crc32(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
  }
  return ~crc;
}

void put_big_endian(std::uint32_t value, char* at) {
  for (int i = 0; i < 4; ++i) {
    at[i] = static_cast<char>(value >> (24 - 8 * i));
  }
}

}  // namespace

std::filesystem::path SmallRecording::image(int view, int frame) const {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%06d.png", frame);
  return sequence() / ("image_" + std::to_string(view)) / name.data();
}

void SmallRecording::write() const {
  std::filesystem::create_directories(sequence() / "image_0");
  std::filesystem::create_directories(sequence() / "image_1");
  write_calibration("0", std::to_string(-kFocal * kBaseline));
  std::ofstream times(sequence() / "times.txt");
  for (int frame = 0; frame < frames; ++frame) {
    times << 0.1 * frame << "\n";
    for (int view = 0; view < 2; ++view) {
      const double view_x_m = x_m(frame) + view * kBaseline;
      write_png(image(view, frame), render(width_px, height_px, view_x_m, *this), width_px, height_px);
    }
  }
}

void SmallRecording::write_calibration(const std::string& left_tx, const std::string& right_tx) const {
  std::ofstream file(calibration());
  const std::array<std::string, 2> tx{left_tx, right_tx};
  for (std::size_t view = 0; view < 2; ++view) {
    file << "P" << view << ": " << kFocal << " 0 " << width_px / 2 << " " << tx[view] << " 0 " << kFocal << " "
         << height_px / 2 << " 0 0 0 1 0\n";
  }
}

void SmallRecording::write_image_of_size(int view, int frame, int width, int height) const {
  write_png(image(view, frame), render(width, height, x_m(frame) + view * kBaseline, *this), width, height);
}

void truncate_file(const std::filesystem::path& path, std::uintmax_t bytes) {
  std::filesystem::resize_file(path, bytes);
}

void forge_png_size(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height) {
  constexpr std::size_t kType = 12;  // After the signature and the chunk's length.
  constexpr std::size_t kChunkBytes = 17;
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  std::array<char, kChunkBytes + 4> chunk{};
  file.seekg(kType);
  file.read(chunk.data(), chunk.size());
  put_big_endian(width, chunk.data() + 4);
  put_big_endian(height, chunk.data() + 8);
  put_big_endian(crc32(reinterpret_cast<const std::uint8_t*>(chunk.data()), kChunkBytes), chunk.data() + kChunkBytes);
  file.seekp(kType);
  file.write(chunk.data(), chunk.size());
}

}  // namespace kinetrace::test
