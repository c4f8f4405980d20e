// Which instruction set the hot kernels may use on this machine.
#pragma once

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// True where the fast kernels run: on x86-64 with AVX2 and FMA (x86-64-v3), on ARM with NEON. The environment variable
/// KINETRACE_ISA=baseline makes it false, so that the portable kernels can be tested and timed on any machine.
/// Evaluated once.
[[nodiscard]] KINETRACE_API bool cpu_runs_fast_kernels() noexcept;

/// The instruction set of the kernels in use: "v3", "neon" or "baseline".
[[nodiscard]] KINETRACE_API const char* kernel_isa() noexcept;

}  // namespace kinetrace
