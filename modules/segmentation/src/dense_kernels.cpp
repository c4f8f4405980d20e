#include "dense_kernels.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::segmentation {

namespace kernel_baseline {
extern const DenseKernels kDenseKernels;
}
namespace kernel_fast {
extern const DenseKernels kDenseKernels;
}

const DenseKernels& baseline_dense_kernels() noexcept {
  return kernel_baseline::kDenseKernels;
}

const DenseKernels& dense_kernels() noexcept {
  return cpu_runs_fast_kernels() ? kernel_fast::kDenseKernels : kernel_baseline::kDenseKernels;
}

}  // namespace kinetrace::segmentation
