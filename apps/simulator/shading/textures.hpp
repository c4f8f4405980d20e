// The looks of the materials, one function for each kind; look_of dispatches. For kernel sources.
#pragma once

#include "util/lanes.hpp"
#include "world/surface.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {

/// Surface points, in the frame of their body.
struct Points {
  Vec3 position;
  Vec3 normal;
  Floats u;  ///< Metres along and up the face.
  Floats v;
  Floats footprint_m;  ///< Size of a pixel there.
};

struct Looks {
  Floats albedo = 0.5F;  ///< Diffuse reflectance.
  Floats gloss = 0.F;    ///< Mirror reflectance at normal incidence.
};

[[nodiscard]] Looks look_of(const Paint& paint, const Points& points);

[[nodiscard]] Looks road_look(const Paint& paint, const Points& point);
[[nodiscard]] Looks building_look(const Paint& paint, const Points& point);
[[nodiscard]] Looks nature_look(const Paint& paint, const Points& point);
[[nodiscard]] Looks vehicle_look(const Paint& paint, const Points& point);
[[nodiscard]] Looks person_look(const Paint& paint, const Points& point);
[[nodiscard]] Looks interior_look(const Paint& paint, const Points& point);

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
