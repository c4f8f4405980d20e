// Image files: PNG, PGM and JPEG, their heads and their pixels, as luminance, colour and labels.
#include <vector>

#include "fuzz_target.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  using namespace imaging;
  constexpr int kSide_px = 64;
  static const ImageReaderConfig config{.max_width_px = kSide_px, .max_height_px = kSide_px, .max_file_bytes = 16384};
  static Arena arena(ImageReader::required_bytes(config));
  static ImageReader reader = ImageReader::create(config, arena).value();
  static MemoryFolder folder;
  const std::string& path = folder.put("image", input);
  const Result<ImageInfo> info = read_image_info(path.c_str());
  if (!info) {
    return;
  }
  require(info->width > 0 && info->height > 0);
  // Exactly as large as an accepted image, so that the sanitizer reports each pixel beyond it.
  const int width = std::min(info->width, kSide_px);
  const int height = std::min(info->height, kSide_px);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> gray(pixels);
  std::vector<Rgb8> rgb(pixels);
  std::vector<std::uint16_t> labels(pixels);
  static_cast<void>(reader.read_gray(path.c_str(), {gray.data(), width, height, width}));
  static_cast<void>(reader.read_rgb(path.c_str(), {rgb.data(), width, height, width}));
  static_cast<void>(reader.read_gray16(path.c_str(), {labels.data(), width, height, width}));
}
