// Where this program lies.
#pragma once

#include <filesystem>
#include <system_error>

namespace kinetrace::app {

/// Of a build, the build's folder; of an installation, PREFIX/bin.
[[nodiscard]] inline std::filesystem::path program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace kinetrace::app
