#include "study/mots_images.hpp"

#include <utility>

namespace kinetrace::app {

Result<evaluation::MotsImage> MotsImages::read(const std::filesystem::path& path, int width_px, int height_px) {
  if (width_px > 0) {
    const Result<imaging::ImageInfo> info = imaging::read_image_info(path.c_str());
    if (!info) {
      return Unexpected(info.error());
    }
    if (info->width != width_px || info->height != height_px) {
      return fail(ErrorCode::kBadFormat, path.string() + ": has " + std::to_string(info->width) + " x " +
                                             std::to_string(info->height) + " pixels, the run's images " +
                                             std::to_string(width_px) + " x " + std::to_string(height_px) +
                                             "; the masks must be of the same rectified images");
    }
  }
  const Result<ImageView<const std::uint16_t>> image = images_.read(path);
  if (!image) {
    return Unexpected(image.error());
  }
  Result<evaluation::MotsImage> labels = evaluation::label_mots_image(*image);
  return labels ? std::move(labels) : fail(labels.error().code, path.string() + ": " + labels.error().message);
}

}  // namespace kinetrace::app
