#include "kinetrace/core/cpu.hpp"

#include <cstdlib>
#include <string_view>

#if defined(__arm__)
#include <asm/hwcap.h>
#include <sys/auxv.h>
#endif

namespace kinetrace {
namespace {

#if defined(__x86_64__)
constexpr const char* kFastIsa = "v3";
bool cpu_has_fast_isa() noexcept {
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
}
#elif defined(__aarch64__)
// NEON is part of the architecture.
constexpr const char* kFastIsa = "neon";
constexpr bool cpu_has_fast_isa() noexcept {
  return true;
}
#elif defined(__arm__)
constexpr const char* kFastIsa = "neon";
bool cpu_has_fast_isa() noexcept {
  constexpr unsigned long kNeeded = HWCAP_NEON | HWCAP_VFPv4;
  return (::getauxval(AT_HWCAP) & kNeeded) == kNeeded;
}
#else
constexpr const char* kFastIsa = "";
constexpr bool cpu_has_fast_isa() noexcept {
  return false;
}
#endif

bool baseline_is_wanted() noexcept {
  const char* wanted = std::getenv("KINETRACE_ISA");
  return wanted != nullptr && std::string_view(wanted) == "baseline";
}

}  // namespace

bool cpu_runs_fast_kernels() noexcept {
  static const bool fast = !baseline_is_wanted() && cpu_has_fast_isa();
  return fast;
}

const char* kernel_isa() noexcept {
  return cpu_runs_fast_kernels() ? kFastIsa : "baseline";
}

}  // namespace kinetrace
