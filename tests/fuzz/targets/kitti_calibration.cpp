// KITTI's calibration text: of the raw recordings, and of the benchmarks.
#include "calibration/kitti_calibration.hpp"

#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const auto file = hal::KittiCalibrationFile::load(folder.put("calib.txt", input));
  if (!file) {
    return;
  }
  constexpr hal::ImageSize kSize{48, 32};
  for (auto rig : {hal::kitti_rectified(*file, "P0", "P1", kSize), hal::kitti_raw_rig(*file, "00", "01", kSize, true),
                   hal::kitti_raw_rig(*file, "00", "01", kSize, false)}) {
    if (rig) {
      static_cast<void>(rig->validate());
    }
  }
}
