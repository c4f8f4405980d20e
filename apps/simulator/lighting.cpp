#include "lighting.hpp"

#include <algorithm>
#include <cmath>

#include "noise.hpp"
#include "pattern.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

// The surroundings as a mirror shows them: sky above a skyline of houses, street below. Only its outline matters.
float surroundings(const Light& light, const Vector3f& direction) {
  constexpr float kHighestRoof = 0.38F;
  constexpr float kStreetEdge = 0.04F;
  const float up = -direction.y();
  const float street = 0.25F * (light.sun + light.ambient);
  const float sky = light.sky * (0.9F - 0.3F * up);
  if (up >= kHighestRoof) {
    return sky;
  }
  if (up <= -kStreetEdge) {
    return street;
  }
  const float azimuth = std::atan2(direction.x(), direction.z());
  const float skyline = 0.2F + 0.07F * std::sin(3.F * azimuth + 1.F) + 0.05F * std::sin(11.F * azimuth) +
                        0.03F * std::sin(29.F * azimuth + 2.F);
  const float houses = (0.2F + 0.06F * std::sin(23.F * azimuth)) * (light.sun + light.ambient);
  return mix(street, mix(houses, sky, soft_step(skyline - 0.03F, skyline + 0.03F, up)),
             soft_step(-kStreetEdge, kStreetEdge, up));
}

float fifth_power(float x) {
  return x * x * x * x * x;
}

}  // namespace

float sky_radiance(const Light& light, const Vector3f& direction) {
  static const Octaves clouds(0.8F, 0.55F, 6, 901);
  const float up = std::max(-direction.y(), 0.02F);
  // Clouds on a sheet high above: small and flat towards the horizon, where they blur.
  const Vector3f on_sheet(direction.x() / up, 0.F, direction.z() / up);
  const float cloud = fractal_noise(clouds, on_sheet, 0.004F / (up * up));
  return light.sky * (1.F - 0.35F * up + 0.1F * cloud);
}

float shaded(const Light& light, const Vector3f& to_sun, const Look& look, const Vector3f& normal, const Vector3f& ray,
             float in_sun) {
  const float up = 0.5F - 0.5F * normal.y();
  const float from_sky = light.ambient * mix(0.4F, 1.F, up);
  const float from_sun = light.sun * in_sun * std::max(normal.dot(to_sun), 0.F);
  float radiance = look.albedo * (from_sky + from_sun) + look.glow;
  if (look.gloss > 0.F) {
    const Vector3f view = ray.normalized();
    const float facing = std::min(std::abs(normal.dot(view)), 1.F);
    const Vector3f mirrored = view - 2.F * normal.dot(view) * normal;
    // Schlick, "An inexpensive BRDF model for physically-based rendering", 1994; half strength at grazing angles, where
    // real surfaces are not perfectly flat.
    const float fresnel = look.gloss + (0.5F - 0.5F * look.gloss) * fifth_power(1.F - facing);
    const float towards_sun = mirrored.dot(to_sun);
    // Far from the mirror image of the sun, nothing of it is left.
    const float glint = towards_sun > 0.8F ? std::pow(towards_sun, 90.F) : 0.F;
    radiance = mix(radiance, surroundings(light, mirrored), fresnel) + 14.F * look.gloss * light.sun * in_sun * glint;
  }
  return radiance;
}

}  // namespace kinetrace::simulator
