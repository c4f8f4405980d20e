#include "kernels.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::features {

#define KINETRACE_DECLARE_KERNELS(isa)                     \
  namespace isa {                                          \
  extern const PyramidKernels kPyramidKernels;             \
  extern const PatchTemplateKernels kPatchTemplateKernels; \
  extern const PatchKernels kPatchKernels;                 \
  extern const SearchKernels kSearchKernels;               \
  extern const CornerKernels kCornerKernels;               \
  extern const WarpKernels kWarpKernels;                   \
  }
KINETRACE_DECLARE_KERNELS(kernel_baseline)
KINETRACE_DECLARE_KERNELS(kernel_fast)
#undef KINETRACE_DECLARE_KERNELS

const Kernels& baseline_kernels() noexcept {
  static const Kernels baseline{kernel_baseline::kPyramidKernels, kernel_baseline::kPatchTemplateKernels,
                                kernel_baseline::kPatchKernels,   kernel_baseline::kSearchKernels,
                                kernel_baseline::kCornerKernels,  kernel_baseline::kWarpKernels};
  return baseline;
}

const Kernels& kernels() noexcept {
  static const Kernels fast{kernel_fast::kPyramidKernels, kernel_fast::kPatchTemplateKernels,
                            kernel_fast::kPatchKernels,   kernel_fast::kSearchKernels,
                            kernel_fast::kCornerKernels,  kernel_fast::kWarpKernels};
  return cpu_runs_fast_kernels() ? fast : baseline_kernels();
}

}  // namespace kinetrace::features
