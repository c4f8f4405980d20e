// The noise kernel, once per instruction set: plain types only.
#pragma once

#include <cstdint>

namespace kinetrace::simulator {

#define KINETRACE_DECLARE_NOISE(isa)                                                                                 \
  namespace isa {                                                                                                    \
  float fractal_noise(const float* frequency, const float* amplitude, std::uint32_t seed, float x, float y, float z, \
                      float footprint) noexcept;                                                                     \
  }

KINETRACE_DECLARE_NOISE(kernel_baseline)
#ifdef KINETRACE_HAVE_V3
KINETRACE_DECLARE_NOISE(kernel_v3)
#endif
#undef KINETRACE_DECLARE_NOISE

}  // namespace kinetrace::simulator
