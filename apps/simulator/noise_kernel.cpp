// One lane per octave. Compiled for each instruction set; see kinetrace_kernel.
#include <cstdint>

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));
using Words = std::uint32_t __attribute__((vector_size(32)));

constexpr std::uint32_t kStepX = 0x8da6b343U;
constexpr std::uint32_t kStepY = 0xd8163841U;
constexpr std::uint32_t kStepZ = 0xcb1ab31fU;

inline Floats load(const float* values) noexcept {
  Floats result;
  __builtin_memcpy(&result, values, sizeof result);
  return result;
}

inline Ints floored(Floats v) noexcept {
  const Ints truncated = __builtin_convertvector(v, Ints);
  return truncated + (__builtin_convertvector(truncated, Floats) > v);
}

inline Floats smooth(Floats t) noexcept {
  return t * t * t * (t * (t * 6.F - 15.F) + 10.F);
}

// The lattice value at a corner, in [-1, 1).
inline Floats corner(Words key) noexcept {
  key ^= key >> 15;
  key *= 0x2c1b3c6dU;
  key ^= key >> 12;
  key *= 0x297a2d39U;
  return __builtin_convertvector(reinterpret_cast<Ints&>(key), Floats) * 0x1p-31F;
}

inline Floats blend(Floats a, Floats b, Floats t) noexcept {
  return a + (b - a) * t;
}

// 1 for octaves whose cells are three times the footprint, 0 for those that a pixel swallows.
inline Floats visible(Floats cells_per_footprint) noexcept {
  Floats t = (0.95F - cells_per_footprint) * (1.F / 0.6F);
  t = t > 1.F ? Floats{} + 1.F : t;
  return t < 0.F ? Floats{} : t;
}

}  // namespace

float fractal_noise(const float* frequency, const float* amplitude, std::uint32_t seed, float x, float y, float z,
                    float footprint) noexcept {
  const Floats f = load(frequency);
  // Lattices of neighbouring octaves must not share their planes.
  const Floats shift = {0.37F, 5.71F, 11.13F, 17.59F, 23.83F, 31.07F, 37.41F, 43.93F};
  const Floats px = f * x + shift;
  const Floats py = f * y - shift;
  const Floats pz = f * z + 2.F * shift;
  const Ints ix = floored(px);
  const Ints iy = floored(py);
  const Ints iz = floored(pz);
  const Floats tx = smooth(px - __builtin_convertvector(ix, Floats));
  const Floats ty = smooth(py - __builtin_convertvector(iy, Floats));
  const Floats tz = smooth(pz - __builtin_convertvector(iz, Floats));
  const Words lane = {0x1U, 0x9e3779b9U, 0x3c6ef372U, 0xdaa66d2bU, 0x78dde6e4U, 0x1715609dU, 0xb54cda56U, 0x5384540fU};
  const Words kx = reinterpret_cast<const Words&>(ix) * kStepX + (lane ^ seed);
  const Words ky = reinterpret_cast<const Words&>(iy) * kStepY;
  const Words kz = reinterpret_cast<const Words&>(iz) * kStepZ;
  const Words kx1 = kx + kStepX;
  const Words ky1 = ky + kStepY;
  const Words kz1 = kz + kStepZ;
  const Floats near_low = blend(corner(kx ^ ky ^ kz), corner(kx1 ^ ky ^ kz), tx);
  const Floats near_high = blend(corner(kx ^ ky1 ^ kz), corner(kx1 ^ ky1 ^ kz), tx);
  const Floats far_low = blend(corner(kx ^ ky ^ kz1), corner(kx1 ^ ky ^ kz1), tx);
  const Floats far_high = blend(corner(kx ^ ky1 ^ kz1), corner(kx1 ^ ky1 ^ kz1), tx);
  const Floats value = blend(blend(near_low, near_high, ty), blend(far_low, far_high, ty), tz);
  const Floats weighted = value * load(amplitude) * visible(f * footprint);
  return ((weighted[0] + weighted[1]) + (weighted[2] + weighted[3])) +
         ((weighted[4] + weighted[5]) + (weighted[6] + weighted[7]));
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
