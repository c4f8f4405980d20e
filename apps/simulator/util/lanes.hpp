// Eight numbers at a time, in registers of the instruction set that is being compiled for. For kernel sources only (see
// kinetrace_kernel): everything is local to that instruction set, and nothing of the standard library is called, whose
// inline functions the linker would share between the instruction sets.
#pragma once

#include <cstdint>

#include "util/lane_arrays.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {

using FloatVector = float __attribute__((vector_size(4 * kLanes)));
using IntVector = std::int32_t __attribute__((vector_size(4 * kLanes)));
using WordVector = std::uint32_t __attribute__((vector_size(4 * kLanes)));

/// Numbers used like one; plain floats are broadcast to eight lanes.
struct Floats {
  FloatVector v;

  Floats() = default;
  Floats(FloatVector lanes) noexcept : v(lanes) {}
  Floats(float x) noexcept : v(x - FloatVector{}) {}
};

/// All bits of a lane are set where it holds.
struct Mask {
  IntVector v;
};

inline Floats operator+(Floats a, Floats b) noexcept {
  return a.v + b.v;
}
inline Floats operator-(Floats a, Floats b) noexcept {
  return a.v - b.v;
}
inline Floats operator*(Floats a, Floats b) noexcept {
  return a.v * b.v;
}
inline Floats operator/(Floats a, Floats b) noexcept {
  return a.v / b.v;
}
inline Floats operator-(Floats a) noexcept {
  return -a.v;
}
inline Mask operator<(Floats a, Floats b) noexcept {
  return {a.v < b.v};
}
inline Mask operator>(Floats a, Floats b) noexcept {
  return {a.v > b.v};
}
inline Mask operator&(Mask a, Mask b) noexcept {
  return {a.v & b.v};
}
inline Mask operator!(Mask a) noexcept {
  return {~a.v};
}

inline Floats select(Mask mask, Floats yes, Floats no) noexcept {
  return mask.v ? yes.v : no.v;
}

/// Of values that fit 32 bits, rounded towards zero.
inline IntVector truncated(Floats x) noexcept {
  return __builtin_convertvector(x.v, IntVector);
}
inline Floats to_floats(IntVector x) noexcept {
  return __builtin_convertvector(x, FloatVector);
}

// Single instructions where available: compilers make several of the vector operators.
#ifdef __AVX__
/// Whether the mask holds in any lane.
inline bool any(Mask mask) noexcept {
  return __builtin_ia32_movmskps256(reinterpret_cast<FloatVector>(mask.v)) != 0;
}
inline Floats min(Floats a, Floats b) noexcept {
  return __builtin_ia32_minps256(b.v, a.v);
}
inline Floats max(Floats a, Floats b) noexcept {
  return __builtin_ia32_maxps256(b.v, a.v);
}
/// Of values that fit 32 bits.
inline Floats floor_of(Floats x) noexcept {
  constexpr int kDown = 1;
  return __builtin_ia32_roundps256(x.v, kDown);
}
#else
inline bool any(Mask mask) noexcept {
  std::int64_t parts[kLanes / 2];
  __builtin_memcpy(parts, &mask.v, sizeof parts);
  return ((parts[0] | parts[1]) | (parts[2] | parts[3])) != 0;
}
inline Floats min(Floats a, Floats b) noexcept {
  return b.v < a.v ? b.v : a.v;
}
inline Floats max(Floats a, Floats b) noexcept {
  return a.v < b.v ? b.v : a.v;
}
inline Floats floor_of(Floats x) noexcept {
  const IntVector towards_zero = truncated(x);
  return to_floats(towards_zero + (to_floats(towards_zero).v > x.v));
}
#endif

inline Floats clamp(Floats x, float low, float high) noexcept {
  return min(max(x, low), high);
}
inline Floats abs(Floats x) noexcept {
  return max(x, -x);
}
inline Floats sqrt(Floats x) noexcept {
  Floats root;
  for (int i = 0; i < kLanes; ++i) {
    root.v[i] = __builtin_sqrtf(x.v[i]);
  }
  return root;
}
/// Length of the vector (x, y).
inline Floats length(Floats x, Floats y) noexcept {
  return sqrt(x * x + y * y);
}
/// Of whole numbers.
inline Mask is_even(Floats x) noexcept {
  return {(truncated(x) & 1) == 0};
}
inline IntVector to_ints(WordVector x) noexcept {
  return reinterpret_cast<const IntVector&>(x);
}
inline WordVector to_words(IntVector x) noexcept {
  return reinterpret_cast<const WordVector&>(x);
}

/// Of angles up to some thousand radians; error below 1e-6 for angles below a hundred.
inline Floats sin(Floats angle) noexcept {
  constexpr float kPi = 3.14159265F;
  // Half turns are subtracted in two steps, the first of them exact.
  constexpr float kPiHead = 3.140625F;
  constexpr float kPiTail = 9.67653590e-4F;
  const Floats half_turns = floor_of(angle * (1.F / kPi) + 0.5F);
  const Floats x = angle - half_turns * kPiHead - half_turns * kPiTail;
  const Floats x2 = x * x;
  // Taylor's series up to the 11th power.
  const Floats series = 1.F - x2 / 6.F * (1.F - x2 / 20.F * (1.F - x2 / 42.F * (1.F - x2 / 72.F * (1.F - x2 / 110.F))));
  return select(is_even(half_turns), x, -x) * series;
}

/// The angle of (x, y) against the x axis, in [-pi, pi], to 1e-6.
inline Floats atan2(Floats y, Floats x) noexcept {
  constexpr float kPi = 3.14159265F;
  const Floats across = abs(y);
  const Floats along = abs(x);
  const Floats t = min(across, along) / max(max(across, along), 1e-30F);
  const Floats t2 = t * t;
  // M. Abramowitz and I. Stegun, "Handbook of mathematical functions", 1964, 4.4.49.
  const float kTerms[] = {-0.0161657367F, 0.0429096138F, -0.0752896400F, 0.1065626393F,
                          -0.1420889944F, 0.1999355085F, -0.3333314528F, 1.F};
  Floats series = 0.0028662257F;
  for (const float term : kTerms) {
    series = series * t2 + term;
  }
  Floats angle = series * t;
  angle = select(across > along, 0.5F * kPi - angle, angle);
  angle = select(x < 0.F, kPi - angle, angle);
  return select(y < 0.F, -angle, angle);
}

struct Vec3 {
  Floats x;
  Floats y;
  Floats z;
};

inline Vec3 operator*(Vec3 a, Floats factor) noexcept {
  return {a.x * factor, a.y * factor, a.z * factor};
}
inline Vec3 operator-(Vec3 a, Vec3 b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Floats dot(Vec3 a, Vec3 b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 normalized(Vec3 a) noexcept {
  return a * (1.F / sqrt(dot(a, a)));
}

inline Floats load(const Lanes& lanes) noexcept {
  Floats result;
  __builtin_memcpy(&result.v, &lanes, sizeof result.v);
  return result;
}
inline Vec3 load(const Lanes3& lanes) noexcept {
  return {load(lanes.x), load(lanes.y), load(lanes.z)};
}
inline void store(Floats x, Lanes& lanes) noexcept {
  __builtin_memcpy(&lanes, &x.v, sizeof x.v);
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
