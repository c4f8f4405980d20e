#include "rectification/lookup_kernel.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::hal {

namespace kernel_baseline {
extern const LookupKernel kLookup;
}
namespace kernel_fast {
extern const LookupKernel kLookup;
}

LookupKernel baseline_lookup_kernel() noexcept {
  return kernel_baseline::kLookup;
}

LookupKernel lookup_kernel() noexcept {
  return cpu_runs_fast_kernels() ? kernel_fast::kLookup : baseline_lookup_kernel();
}

}  // namespace kinetrace::hal
