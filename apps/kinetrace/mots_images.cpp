#include "mots_images.hpp"

#include <utility>

namespace kinetrace::app {

Result<evaluation::MotsImage> MotsImages::read(const std::filesystem::path& path) {
  const Result<ImageView<const std::uint16_t>> image = images_.read(path);
  if (!image) {
    return Unexpected(image.error());
  }
  Result<evaluation::MotsImage> labels = evaluation::label_mots_image(*image);
  return labels ? std::move(labels) : fail(labels.error().code, path.string() + ": " + labels.error().message);
}

}  // namespace kinetrace::app
