// A recording in EuRoC's layout: its two sensor.yaml and its two lists of images.
#include "fuzz_target.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "memory_folder.hpp"
#include "small_image.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static const bool has_images = [] {
    for (const char* stem : {"1403636579763555584", "1403636579813555456", "1403636579863555584"}) {
      for (const char* camera : {"mav0/cam0/data/", "mav0/cam1/data/"}) {
        folder.put(std::string(camera) + stem + ".pgm", small_image());
      }
    }
    return true;
  }();
  require(has_images);
  folder.put_parts({"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/cam0/data.csv", "mav0/cam1/data.csv"},
                   input);
  static_cast<void>(hal::open_dataset({.layout = hal::DatasetLayout::kEuroc, .path = folder.path()}));
}
