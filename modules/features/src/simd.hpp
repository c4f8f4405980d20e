// Vectors of floats as wide as a register of the instruction set. For kernel sources only: everything is local to the
// instruction set being compiled.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {

#if defined(__AVX2__)
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

using Floats = float __attribute__((vector_size(4 * kLanes)));
using Ints = std::int32_t __attribute__((vector_size(4 * kLanes)));

static inline Floats load(const float* source) {
  Floats v;
  __builtin_memcpy(&v, source, sizeof(v));
  return v;
}

static inline void store(float* target, Floats v) {
  __builtin_memcpy(target, &v, sizeof(v));
}

static inline Floats splat(float x) {
  return Floats{} + x;
}

/// first, first + 1, first + 2...
static inline Floats ramp(float first) {
  Floats v;
  for (int i = 0; i < kLanes; ++i) {
    v[i] = first + static_cast<float>(i);
  }
  return v;
}

static inline float sum(Floats v) {
  float total = 0.F;
  for (int i = 0; i < kLanes / 2; ++i) {
    total += v[i] + v[i + kLanes / 2];
  }
  return total;
}

// Intrinsics in the next five functions only: GCC's vector extensions have neither a widening byte load that compiles
// to one instruction, nor a gather, nor a product of halves, nor a square root, nor a sum of absolute differences.

/// The next kLanes bytes as floats.
static inline Floats load_bytes(const std::uint8_t* source) {
#if defined(__AVX2__)
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(source));
  return (Floats)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
#elif defined(__SSE2__)
  std::int32_t four;
  __builtin_memcpy(&four, source, sizeof(four));
  const __m128i zero = _mm_setzero_si128();
  const __m128i words = _mm_unpacklo_epi8(_mm_cvtsi32_si128(four), zero);
  return (Floats)_mm_cvtepi32_ps(_mm_unpacklo_epi16(words, zero));
#elif defined(__ARM_NEON)
  std::uint32_t four;
  __builtin_memcpy(&four, source, sizeof(four));
  const uint16x8_t words = vmovl_u8(vcreate_u8(four));
  return (Floats)vcvtq_f32_u32(vmovl_u16(vget_low_u16(words)));
#else
  Floats v;
  for (int i = 0; i < kLanes; ++i) {
    v[i] = static_cast<float>(source[i]);
  }
  return v;
#endif
}

/// The two bytes at each offset, in the lower halves; the upper halves are unspecified. May read four bytes from each
/// offset.
static inline Ints gather_pairs(const std::uint8_t* base, Ints offsets) {
#if defined(__AVX2__)
  return (Ints)_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), (__m256i)offsets, 1);
#elif defined(__SSE2__)
  const auto pair = [&](int i) {
    std::uint16_t bytes;
    __builtin_memcpy(&bytes, base + offsets[i], sizeof(bytes));
    return static_cast<int>(bytes);
  };
  __m128i pairs = _mm_setzero_si128();
  pairs = _mm_insert_epi16(pairs, pair(0), 0);
  pairs = _mm_insert_epi16(pairs, pair(1), 2);
  pairs = _mm_insert_epi16(pairs, pair(2), 4);
  return (Ints)_mm_insert_epi16(pairs, pair(3), 6);
#else
  Ints pairs;
  for (int i = 0; i < kLanes; ++i) {
    std::uint16_t pair;
    __builtin_memcpy(&pair, base + offsets[i], sizeof(pair));
    pairs[i] = pair;
  }
  return pairs;
#endif
}

/// The product of numbers in [0, 2^15): one instruction of the baseline instead of six.
static inline Ints multiply_small(Ints small, int factor) {
#if defined(__SSE2__) && !defined(__AVX2__)
  return (Ints)_mm_madd_epi16((__m128i)small, _mm_set1_epi32(factor));
#else
  return small * factor;
#endif
}

static inline Floats square_root(Floats v) {
#if defined(__AVX2__)
  return (Floats)_mm256_sqrt_ps((__m256)v);
#elif defined(__SSE2__)
  return (Floats)_mm_sqrt_ps((__m128)v);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (Floats)vsqrtq_f32((float32x4_t)v);
#else
  for (int i = 0; i < kLanes; ++i) {
    v[i] = __builtin_sqrtf(v[i]);
  }
  return v;
#endif
}

/// A patch of 16 x kRows bytes to compare with others. One call compares with kAtOnce patches: those at `other` and, 16
/// bytes further on each, the next.
template <int kRows>
struct BytePatch {
#if defined(__AVX2__)
  static constexpr int kAtOnce = 2;
#else
  static constexpr int kAtOnce = 1;
#endif
  alignas(16) std::uint8_t rows[kRows][16];

  void differences(const std::uint8_t* other, int stride, unsigned* sums) const {
#if defined(__AVX2__)
    __m256i total = _mm256_setzero_si256();
    for (int y = 0; y < kRows; ++y) {
      const __m256i mine = _mm256_broadcastsi128_si256(_mm_load_si128(reinterpret_cast<const __m128i*>(rows[y])));
      const __m256i theirs = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(other + y * stride));
      total = _mm256_add_epi32(total, _mm256_sad_epu8(mine, theirs));
    }
    const __m256i halves = _mm256_add_epi32(total, _mm256_bsrli_epi128(total, 8));
    sums[0] = static_cast<unsigned>(_mm256_extract_epi32(halves, 0));
    sums[1] = static_cast<unsigned>(_mm256_extract_epi32(halves, 4));
#elif defined(__SSE2__)
    __m128i total = _mm_setzero_si128();
    for (int y = 0; y < kRows; ++y) {
      const __m128i mine = _mm_load_si128(reinterpret_cast<const __m128i*>(rows[y]));
      const __m128i theirs = _mm_loadu_si128(reinterpret_cast<const __m128i*>(other + y * stride));
      total = _mm_add_epi32(total, _mm_sad_epu8(mine, theirs));
    }
    sums[0] = static_cast<unsigned>(_mm_cvtsi128_si32(_mm_add_epi32(total, _mm_bsrli_si128(total, 8))));
#elif defined(__ARM_NEON)
    uint16x8_t total = vdupq_n_u16(0);
    for (int y = 0; y < kRows; ++y) {
      total = vpadalq_u8(total, vabdq_u8(vld1q_u8(rows[y]), vld1q_u8(other + y * stride)));
    }
    const uint64x2_t halves = vpaddlq_u32(vpaddlq_u16(total));
    sums[0] = static_cast<unsigned>(vgetq_lane_u64(halves, 0) + vgetq_lane_u64(halves, 1));
#else
    sums[0] = 0;
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < 16; ++x) {
        const int difference = rows[y][x] - other[y * stride + x];
        sums[0] += static_cast<unsigned>(difference < 0 ? -difference : difference);
      }
    }
#endif
  }
};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
