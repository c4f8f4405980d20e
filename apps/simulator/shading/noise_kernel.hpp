// Solid fractal noise, for kernel sources.
#pragma once

#include "shading/noise.hpp"
#include "util/lanes.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {

/// As kinetrace::simulator::fractal_noise.
[[nodiscard]] Floats fractal_noise(const Octaves& octaves, const Vec3& point, Floats footprint_m) noexcept;

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
