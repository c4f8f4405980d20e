// Compiled for each instruction set; see kinetrace_kernel.
#include "shading/noise_kernel.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

constexpr std::uint32_t kStepX = 0x8da6b343U;
constexpr std::uint32_t kStepY = 0xd8163841U;
constexpr std::uint32_t kStepZ = 0xcb1ab31fU;

// Shifts prevent neighbouring octaves from sharing lattice planes.
constexpr float kShift[Octaves::kMax] = {0.37F, 5.71F, 11.13F, 17.59F, 23.83F, 31.07F, 37.41F, 43.93F};
constexpr std::uint32_t kKey[Octaves::kMax] = {0x1U,        0x9e3779b9U, 0x3c6ef372U, 0xdaa66d2bU,
                                               0x78dde6e4U, 0x1715609dU, 0xb54cda56U, 0x5384540fU};

Floats smooth(Floats t) noexcept {
  return t * t * t * (t * (t * 6.F - 15.F) + 10.F);
}

// The first step of a corner's hash. It folds the parts of a key one by one, as folding commutes with exclusive or.
WordVector merged(WordVector key) noexcept {
  return key ^ (key >> 15);
}

// The lattice value at a corner, in [-2^31, 2^31), from its folded key.
Floats corner(WordVector key) noexcept {
  key *= 0x2c1b3c6dU;
  key ^= key >> 12;
  key *= 0x297a2d39U;
  return to_floats(to_ints(key));
}

Floats blend(Floats a, Floats b, Floats t) noexcept {
  return a + (b - a) * t;
}

// In [-1, 1); `point` in cells.
Floats value_noise(const Vec3& point, std::uint32_t seed) noexcept {
  const Vec3 cell{floor_of(point.x), floor_of(point.y), floor_of(point.z)};
  const Floats tx = smooth(point.x - cell.x);
  const Floats ty = smooth(point.y - cell.y);
  const Floats tz = smooth(point.z - cell.z);
  const WordVector place_x = to_words(truncated(cell.x)) * kStepX + seed;
  const WordVector place_y = to_words(truncated(cell.y)) * kStepY;
  const WordVector place_z = to_words(truncated(cell.z)) * kStepZ;
  const WordVector kx = merged(place_x);
  const WordVector ky = merged(place_y);
  const WordVector kz = merged(place_z);
  const WordVector kx1 = merged(place_x + kStepX);
  const WordVector ky1 = merged(place_y + kStepY);
  const WordVector kz1 = merged(place_z + kStepZ);
  const Floats near_low = blend(corner(kx ^ ky ^ kz), corner(kx1 ^ ky ^ kz), tx);
  const Floats near_high = blend(corner(kx ^ ky1 ^ kz), corner(kx1 ^ ky1 ^ kz), tx);
  const Floats far_low = blend(corner(kx ^ ky ^ kz1), corner(kx1 ^ ky ^ kz1), tx);
  const Floats far_high = blend(corner(kx ^ ky1 ^ kz1), corner(kx1 ^ ky1 ^ kz1), tx);
  return blend(blend(near_low, near_high, ty), blend(far_low, far_high, ty), tz) * 0x1p-31F;
}

// 1 for octaves whose cells are three times the footprint, 0 for those that a pixel does not resolve.
Floats visible(Floats cells_per_footprint) noexcept {
  return clamp((0.95F - cells_per_footprint) * (1.F / 0.6F), 0.F, 1.F);
}

}  // namespace

Floats fractal_noise(const Octaves& octaves, const Vec3& point, Floats footprint_m) noexcept {
  Floats sum(0.F);
  for (int i = 0; i < octaves.count; ++i) {
    const float frequency = octaves.frequency[i];
    const Floats seen = visible(frequency * footprint_m);
    if (!any(seen > 0.F)) {
      break;
    }
    const float shift = kShift[i];
    const Vec3 cell = {frequency * point.x + shift, frequency * point.y - shift, frequency * point.z + 2.F * shift};
    sum = sum + value_noise(cell, kKey[i] ^ octaves.seed) * octaves.amplitude[i] * seen;
  }
  return sum;
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
