// Resident memory of this process.
#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

namespace kinetrace::test {

/// Resident bytes: exact from /proc/self/smaps_rollup where the kernel has it, else from /proc/self/status, which may
/// lag by some hundred KiB. 0 where there is neither.
[[nodiscard]] inline std::uint64_t resident_bytes() {
  for (const auto& [path, key] : {std::pair{"/proc/self/smaps_rollup", "Rss:"}, {"/proc/self/status", "VmRSS:"}}) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      if (line.rfind(key, 0) == 0) {
        std::uint64_t kib = 0;
        std::istringstream(line.substr(std::string(key).size())) >> kib;
        return kib * 1024;
      }
    }
  }
  return 0;
}

}  // namespace kinetrace::test
