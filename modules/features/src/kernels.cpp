#include "kernels.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::features {

#define KINETRACE_DECLARE_KERNELS(isa)         \
  namespace isa {                              \
  extern const PyramidKernels kPyramidKernels; \
  extern const PatchKernels kPatchKernels;     \
  extern const SearchKernels kSearchKernels;   \
  extern const CornerKernels kCornerKernels;   \
  }
KINETRACE_DECLARE_KERNELS(kernel_baseline)
#ifdef KINETRACE_HAVE_V3
KINETRACE_DECLARE_KERNELS(kernel_v3)
#endif
#undef KINETRACE_DECLARE_KERNELS

const Kernels& kernels() noexcept {
  static const Kernels chosen = [] {
#ifdef KINETRACE_HAVE_V3
    if (cpu_has_v3()) {
      return Kernels{kernel_v3::kPyramidKernels, kernel_v3::kPatchKernels, kernel_v3::kSearchKernels,
                     kernel_v3::kCornerKernels};
    }
#endif
    return Kernels{kernel_baseline::kPyramidKernels, kernel_baseline::kPatchKernels, kernel_baseline::kSearchKernels,
                   kernel_baseline::kCornerKernels};
  }();
  return chosen;
}

}  // namespace kinetrace::features
