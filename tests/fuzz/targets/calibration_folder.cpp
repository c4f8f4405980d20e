// Two calibration files in YAML: a pair of ROS CameraInfo, or OpenCV's intrinsics and extrinsics.
#include "fuzz_target.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put_parts({"left.yaml", "right.yaml"}, input);
  static_cast<void>(hal::read_rig_calibration(folder.path(), 48, 32));
}
