// 16-bit images from files: labels and depths.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::app {

class Gray16Images {
 public:
  /// The pixels live until the next call. Errors, naming the file: those of imaging::read_image_info and
  /// ImageReader::read_gray16.
  [[nodiscard]] Result<ImageView<const std::uint16_t>> read(const std::filesystem::path& path);
  /// Of the file that was read last.
  [[nodiscard]] int bit_depth() const noexcept { return bit_depth_; }

 private:
  std::optional<Arena> arena_;  ///< Taken with the first image.
  std::optional<imaging::ImageReader> reader_;
  std::vector<std::uint16_t> pixels_;
  int bit_depth_ = 0;
};

}  // namespace kinetrace::app
