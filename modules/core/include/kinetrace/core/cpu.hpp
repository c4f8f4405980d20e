// Which instruction set the hot kernels may use on this machine.
#pragma once

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// True on x86-64 processors with AVX2 and FMA. The environment variable KINETRACE_ISA=baseline makes it false, so that
/// the portable kernels can be tested and timed on any machine. Decided once.
[[nodiscard]] KINETRACE_API bool cpu_has_v3() noexcept;

}  // namespace kinetrace
