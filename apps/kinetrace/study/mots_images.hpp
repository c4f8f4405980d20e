// KITTI MOTS images from files, as labels.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"
#include "study/gray16_images.hpp"

namespace kinetrace::app {

class MotsImages {
 public:
  /// `width_px`, `height_px`: required size; 0: any size. Errors, naming the file: kBadFormat (another size), those of
  /// Gray16Images and of label_mots_image.
  [[nodiscard]] Result<evaluation::MotsImage> read(const std::filesystem::path& path, int width_px = 0,
                                                   int height_px = 0);

 private:
  Gray16Images images_;
};

}  // namespace kinetrace::app
