// KITTI MOTS images from files, as labels.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::app {

class MotsImages {
 public:
  /// Errors, naming the file: those of imaging::read_image_info and ImageReader::read_gray16, and of label_mots_image.
  [[nodiscard]] Result<evaluation::MotsImage> read(const std::filesystem::path& path);

 private:
  std::optional<Arena> arena_;  ///< Taken with the first image.
  std::optional<imaging::ImageReader> reader_;
  std::vector<std::uint16_t> pixels_;
};

}  // namespace kinetrace::app
