// The looks of the materials, one function for each kind; look_of dispatches.
#pragma once

#include "surface.hpp"

namespace kinetrace::simulator {

[[nodiscard]] Look road_look(const Paint& paint, const SurfacePoint& point);
[[nodiscard]] Look building_look(const Paint& paint, const SurfacePoint& point);
[[nodiscard]] Look nature_look(const Paint& paint, const SurfacePoint& point);
[[nodiscard]] Look vehicle_look(const Paint& paint, const SurfacePoint& point);
[[nodiscard]] Look person_look(const Paint& paint, const SurfacePoint& point);
[[nodiscard]] Look interior_look(const Paint& paint, const SurfacePoint& point);

}  // namespace kinetrace::simulator
