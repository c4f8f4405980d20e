// KITTI MOTS images from files, as labels.
#pragma once

#include <filesystem>

#include "gray16_images.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"

namespace kinetrace::app {

class MotsImages {
 public:
  /// Errors, naming the file: those of Gray16Images and of label_mots_image.
  [[nodiscard]] Result<evaluation::MotsImage> read(const std::filesystem::path& path);

 private:
  Gray16Images images_;
};

}  // namespace kinetrace::app
