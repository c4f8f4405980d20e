// Folder of this program.
#pragma once

#include <filesystem>
#include <system_error>

namespace kinetrace::app {

/// In a build, the build folder; in an installation, PREFIX/bin.
[[nodiscard]] inline std::filesystem::path program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace kinetrace::app
