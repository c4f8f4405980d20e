// The calibration of a DepthAI device, or OpenCV's, in JSON.
#include "fuzz_target.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(hal::read_rig_calibration(folder.put("oak.json", input), 48, 32));
}
