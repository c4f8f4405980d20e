// A camera file.
#include "camera/camera_config.hpp"
#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(app::load_camera_config(folder.put("camera.yaml", input)));
}
