// A recording of KITTI odometry: its calibration and its times together, with images 0, 1 and 3.
#include "fuzz_target.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "memory_folder.hpp"
#include "small_image.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static const bool has_images = [] {
    for (const char* name : {"image_0/000000.pgm", "image_0/000001.pgm", "image_0/000003.pgm", "image_1/000000.pgm",
                             "image_1/000001.pgm", "image_1/000003.pgm"}) {
      folder.put(name, small_image());
    }
    return true;
  }();
  require(has_images);
  folder.put_parts({"calib.txt", "times.txt"}, input);
  static_cast<void>(hal::open_dataset({.layout = hal::DatasetLayout::kKittiOdometry, .path = folder.path()}));
}
