// Light: sun, sky, and what mirrors.
#pragma once

#include <Eigen/Core>

#include "scene.hpp"
#include "surface.hpp"

namespace kinetrace::simulator {

/// Brightness of the sky in a direction (unit length, y down).
[[nodiscard]] float sky_radiance(const Light& light, const Eigen::Vector3f& direction);

/// Light that leaves a surface towards the viewer. `normal` has unit length, `ray` (from the eye to the surface) any;
/// `in_sun` is the part of the sun that is not blocked.
[[nodiscard]] float shaded(const Light& light, const Eigen::Vector3f& to_sun, const Look& look,
                           const Eigen::Vector3f& normal, const Eigen::Vector3f& ray, float in_sun);

}  // namespace kinetrace::simulator
