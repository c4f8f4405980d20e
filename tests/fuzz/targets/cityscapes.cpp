// The camera file of a Cityscapes recording.
#include "fuzz_target.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "memory_folder.hpp"
#include "small_image.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static const bool has_images = [] {
    folder.put("leftImg8bit/val/city/city_000000_000001_leftImg8bit.pgm", small_image());
    folder.put("rightImg8bit/val/city/city_000000_000001_rightImg8bit.pgm", small_image());
    return true;
  }();
  require(has_images);
  folder.put("camera/val/city/city_000000_000001_camera.json", input);
  static_cast<void>(hal::open_dataset({.layout = hal::DatasetLayout::kCityscapes, .path = folder.path()}));
}
