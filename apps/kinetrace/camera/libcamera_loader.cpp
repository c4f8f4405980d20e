#include "camera/libcamera_loader.hpp"

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "cli/messages.hpp"
#include "cli/program_folder.hpp"
#include "kinetrace/hal/libcamera_backend.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

bool load_once() {
  // Kinetrace reports errors itself; a user who wants libcamera's log has set the variable already.
  setenv("LIBCAMERA_LOG_LEVELS", "*:ERROR", 0);
  std::error_code error;
  const fs::path folder = program_folder();
  // Folders of a build and of an installation (bin/kinetrace).
  for (const char* place : {"kinetrace-libcamera.so", "../lib/kinetrace/kinetrace-libcamera.so"}) {
    const fs::path plugin = folder / place;
    if (!fs::exists(plugin, error)) {
      continue;
    }
    if (const Status loaded = hal::load_libcamera_plugin(plugin); !loaded) {
      print_warning(loaded.error().message);
    }
    return true;
  }
  return false;
}

}  // namespace

void load_libcamera() {
  [[maybe_unused]] static const bool found = load_once();
}

}  // namespace kinetrace::app
