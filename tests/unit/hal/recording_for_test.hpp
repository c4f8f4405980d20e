// Small recordings on disk, made by code.
#pragma once

#include <cstdint>
#include <string>

#include "kinetrace/hal/dataset.hpp"
#include "temp_folder.hpp"

namespace kinetrace::hal::test {

inline constexpr int kWidth = 48;
inline constexpr int kHeight = 32;

void write_text(const std::string& path, const std::string& text);
/// A gray PNG of one value.
void write_image(const std::string& path, std::uint8_t value, int width = kWidth, int height = kHeight);
void write_image16(const std::string& path, std::uint16_t value, int width = kWidth, int height = kHeight);
/// The first `bytes` bytes of such an image.
void write_cut_image(const std::string& path, std::size_t bytes);
void write_color_image(const std::string& path, std::uint8_t value, int width = kWidth, int height = kHeight);

/// "P0: ..." to "P3: ..." with focal length 40, principal point (24, 16), camera 1 at .5 m, 2 at -.06 m, 3 at .47 m.
[[nodiscard]] std::string kitti_projections();

/// A KITTI odometry sequence with pairs 0 .. count - 1; the left image of frame i has the value i, the right one 100 +
/// i.
class Recording {
 public:
  explicit Recording(int count);
  [[nodiscard]] std::string left(int i) const;
  [[nodiscard]] std::string right(int i) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Result<Dataset> open() const;

 private:
  kinetrace::test::TempFolder folder_;
  std::filesystem::path path_ = folder_.path() / "sequence";
};

}  // namespace kinetrace::hal::test
