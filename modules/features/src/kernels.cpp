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

const Kernels& baseline_kernels() noexcept {
  static const Kernels baseline{kernel_baseline::kPyramidKernels, kernel_baseline::kPatchKernels,
                                kernel_baseline::kSearchKernels, kernel_baseline::kCornerKernels};
  return baseline;
}

const Kernels& kernels() noexcept {
#ifdef KINETRACE_HAVE_V3
  static const Kernels v3{kernel_v3::kPyramidKernels, kernel_v3::kPatchKernels, kernel_v3::kSearchKernels,
                          kernel_v3::kCornerKernels};
  if (cpu_has_v3()) {
    return v3;
  }
#endif
  return baseline_kernels();
}

}  // namespace kinetrace::features
