#include "kinetrace/core/cpu.hpp"

#include <cstdlib>
#include <string_view>

namespace kinetrace {

bool cpu_has_v3() noexcept {
#if defined(__x86_64__)
  static const bool has_v3 = [] {
    const char* forced = std::getenv("KINETRACE_ISA");
    if (forced != nullptr && std::string_view(forced) == "baseline") {
      return false;
    }
    return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  }();
  return has_v3;
#else
  return false;
#endif
}

}  // namespace kinetrace
