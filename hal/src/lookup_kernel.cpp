#include "lookup_kernel.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::hal {

namespace kernel_baseline {
extern const LookupKernel kLookup;
}
#ifdef KINETRACE_HAVE_V3
namespace kernel_v3 {
extern const LookupKernel kLookup;
}
#endif

LookupKernel baseline_lookup_kernel() noexcept {
  return kernel_baseline::kLookup;
}

LookupKernel lookup_kernel() noexcept {
#ifdef KINETRACE_HAVE_V3
  if (cpu_has_v3()) {
    return kernel_v3::kLookup;
  }
#endif
  return baseline_lookup_kernel();
}

}  // namespace kinetrace::hal
