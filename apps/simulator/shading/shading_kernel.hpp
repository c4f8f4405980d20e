// Light from surfaces and the sky to the camera, eight rays at a time; compiled for each instruction set, with
// bit-identical results.
#pragma once

#include "shading/noise.hpp"
#include "shading/surface_pack.hpp"
#include "world/surface.hpp"

namespace kinetrace::simulator {

/// A scene's light in the form of the kernels: see Light.
struct Daylight {
  float to_sun[3]{};  ///< Unit length, scene frame.
  float sun = 0.F;
  float ambient = 0.F;
  float sky = 0.F;
};

/// One set of kernels; results are written to the last argument.
struct ShadingKernel {
  /// As fractal_noise.
  void (*noise)(const Octaves& octaves, const Lanes3& points, const Lanes& footprint_m, Lanes& values);
  /// Light that leaves surfaces towards the camera.
  void (*shade)(const Paint& paint, const SurfacePack& points, const Daylight& light, Lanes& radiance);
  /// Brightness of the sky in some directions, of any length, y down.
  void (*shade_sky)(const Lanes3& directions, const Daylight& light, Lanes& radiance);
};

namespace kernel_baseline {
extern const ShadingKernel shading_kernel;
}
namespace kernel_fast {
extern const ShadingKernel shading_kernel;
}

/// The fastest one that this machine supports.
[[nodiscard]] const ShadingKernel& shading_kernel();

}  // namespace kinetrace::simulator
