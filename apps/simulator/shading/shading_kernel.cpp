// Illumination: sun, sky, and reflections. Compiled for each instruction set; see kinetrace_kernel.
#include "shading/shading_kernel.hpp"

#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

// The reflected surroundings: sky above a skyline of houses, street below. Only their outline matters.
Floats surroundings(const Daylight& light, const Vec3& direction) {
  constexpr float kMaxRoof = 0.38F;
  constexpr float kStreetEdge = 0.04F;
  const Floats up = -direction.y;
  const float street = 0.25F * (light.sun + light.ambient);
  const Floats sky = light.sky * (0.9F - 0.3F * up);
  const Mask below_roofs = up < kMaxRoof;
  const Mask before_houses = below_roofs & (up > -kStreetEdge);
  const Floats without_houses = select(below_roofs, street, sky);
  if (!any(before_houses)) {
    return without_houses;
  }
  const Floats azimuth = atan2(direction.x, direction.z);
  const Floats skyline =
      0.2F + 0.07F * sin(3.F * azimuth + 1.F) + 0.05F * sin(11.F * azimuth) + 0.03F * sin(29.F * azimuth + 2.F);
  const Floats houses = (0.2F + 0.06F * sin(23.F * azimuth)) * (light.sun + light.ambient);
  return select(before_houses,
                mix(street, mix(houses, sky, soft_step(skyline - 0.03F, skyline + 0.03F, up)),
                    soft_step(-kStreetEdge, kStreetEdge, up)),
                without_houses);
}

Floats fifth_power(Floats x) {
  return x * x * x * x * x;
}

Floats ninetieth_power(Floats x) {
  const Floats x2 = x * x;
  const Floats x8 = (x2 * x2) * (x2 * x2);
  const Floats x16 = x8 * x8;
  const Floats x64 = (x16 * x16) * (x16 * x16);
  return x64 * x16 * x8 * x2;
}

// Change of a matt surface's light by `gloss`.
Floats glossed(const Daylight& light, const Vec3& to_sun, Floats matt, Floats gloss, const Vec3& normal,
               const Vec3& ray, Floats in_sun) {
  const Vec3 view = normalized(ray);
  const Floats along_normal = dot(normal, view);
  const Floats facing = min(abs(along_normal), 1.F);
  const Vec3 mirrored = view - normal * (2.F * along_normal);
  // Schlick, "An inexpensive BRDF model for physically-based rendering", 1994; half strength at grazing angles, where
  // real surfaces are not perfectly flat.
  const Floats fresnel = gloss + (0.5F - 0.5F * gloss) * fifth_power(1.F - facing);
  const Floats towards_sun = dot(mirrored, to_sun);
  // The sun's reflection is negligible far from its mirror direction.
  const Floats glint = select(towards_sun > 0.8F, ninetieth_power(towards_sun), 0.F);
  return mix(matt, surroundings(light, mirrored), fresnel) + 14.F * gloss * light.sun * in_sun * glint;
}

void shade(const Paint& paint, const SurfacePack& pack, const Daylight& light, Lanes& radiance) {
  const Looks look =
      look_of(paint, {load(pack.position), load(pack.normal), load(pack.u), load(pack.v), load(pack.footprint_m)});
  const Vec3 normal = load(pack.scene_normal);
  const Vec3 to_sun{light.to_sun[0], light.to_sun[1], light.to_sun[2]};
  const Floats in_sun = load(pack.in_sun);
  const Floats up = 0.5F - 0.5F * normal.y;
  const Floats from_sky = light.ambient * mix(0.4F, 1.F, up);
  const Floats from_sun = light.sun * in_sun * max(dot(normal, to_sun), 0.F);
  Floats leaving = look.albedo * (from_sky + from_sun);
  if (const Mask glossy = look.gloss > 0.F; any(glossy)) {
    leaving = select(glossy, glossed(light, to_sun, leaving, look.gloss, normal, load(pack.ray), in_sun), leaving);
  }
  store(leaving, radiance);
}

void shade_sky(const Lanes3& directions, const Daylight& light, Lanes& radiance) {
  static const Octaves clouds(0.8F, 0.55F, 6, 901);
  const Vec3 direction = normalized(load(directions));
  const Floats up = max(-direction.y, 0.02F);
  // Clouds on a sheet high above: small and flat towards the horizon, where they blur.
  const Vec3 on_sheet{direction.x / up, 0.F, direction.z / up};
  const Floats cloud = fractal_noise(clouds, on_sheet, 0.004F / (up * up));
  store(light.sky * (1.F - 0.35F * up + 0.1F * cloud), radiance);
}

void noise(const Octaves& octaves, const Lanes3& points, const Lanes& footprint_m, Lanes& values) {
  store(fractal_noise(octaves, load(points), load(footprint_m)), values);
}

}  // namespace

const ShadingKernel shading_kernel{noise, shade, shade_sky};

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
