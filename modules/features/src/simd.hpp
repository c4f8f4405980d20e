// Eight floats at once, for kernel sources only: everything is local to the instruction set being compiled.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

namespace kinetrace::features::KINETRACE_KERNEL_ISA {

using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));

static inline Float8 load(const float* source) {
  Float8 v;
  __builtin_memcpy(&v, source, sizeof(v));
  return v;
}

static inline void store(float* target, Float8 v) {
  __builtin_memcpy(target, &v, sizeof(v));
}

static inline Float8 splat(float x) {
  return Float8{x, x, x, x, x, x, x, x};
}

static inline float sum(Float8 v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// Intrinsics in the next three functions only: GCC's vector extensions have neither a widening byte load that compiles
// to one instruction, nor a square root, nor a sum of absolute differences.

/// Eight bytes as floats.
static inline Float8 load_bytes(const std::uint8_t* source) {
#if defined(__AVX2__)
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(source));
  return (Float8)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
#elif defined(__SSE2__)
  const __m128i zero = _mm_setzero_si128();
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(source));
  const __m128i words = _mm_unpacklo_epi8(bytes, zero);
  const __m128 low = _mm_cvtepi32_ps(_mm_unpacklo_epi16(words, zero));
  const __m128 high = _mm_cvtepi32_ps(_mm_unpackhi_epi16(words, zero));
  Float8 v;
  __builtin_memcpy(&v, &low, sizeof(low));
  __builtin_memcpy(reinterpret_cast<char*>(&v) + sizeof(low), &high, sizeof(high));
  return v;
#elif defined(__ARM_NEON)
  const uint16x8_t words = vmovl_u8(vld1_u8(source));
  const float32x4_t low = vcvtq_f32_u32(vmovl_u16(vget_low_u16(words)));
  const float32x4_t high = vcvtq_f32_u32(vmovl_u16(vget_high_u16(words)));
  Float8 v;
  __builtin_memcpy(&v, &low, sizeof(low));
  __builtin_memcpy(reinterpret_cast<char*>(&v) + sizeof(low), &high, sizeof(high));
  return v;
#else
  Float8 v;
  for (int i = 0; i < 8; ++i) {
    v[i] = static_cast<float>(source[i]);
  }
  return v;
#endif
}

static inline Float8 square_root(Float8 v) {
#if defined(__AVX2__)
  return (Float8)_mm256_sqrt_ps((__m256)v);
#elif defined(__SSE2__)
  __m128 halves[2];
  __builtin_memcpy(halves, &v, sizeof(v));
  halves[0] = _mm_sqrt_ps(halves[0]);
  halves[1] = _mm_sqrt_ps(halves[1]);
  __builtin_memcpy(&v, halves, sizeof(v));
  return v;
#else
  for (int i = 0; i < 8; ++i) {
    v[i] = __builtin_sqrtf(v[i]);
  }
  return v;
#endif
}

/// Sum of absolute differences of `rows` rows of 16 bytes.
static inline unsigned absolute_difference(const std::uint8_t* a, int stride_a, const std::uint8_t* b, int stride_b,
                                           int rows) {
#if defined(__SSE2__)
  __m128i total = _mm_setzero_si128();
  for (int y = 0; y < rows; ++y) {
    const __m128i row_a = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a + y * stride_a));
    const __m128i row_b = _mm_loadu_si128(reinterpret_cast<const __m128i*>(b + y * stride_b));
    total = _mm_add_epi32(total, _mm_sad_epu8(row_a, row_b));
  }
  return static_cast<unsigned>(_mm_cvtsi128_si32(total) + _mm_extract_epi16(total, 4));
#elif defined(__ARM_NEON)
  uint16x8_t total = vdupq_n_u16(0);
  for (int y = 0; y < rows; ++y) {
    total = vpadalq_u8(total, vabdq_u8(vld1q_u8(a + y * stride_a), vld1q_u8(b + y * stride_b)));
  }
  const uint64x2_t halves = vpaddlq_u32(vpaddlq_u16(total));
  return static_cast<unsigned>(vgetq_lane_u64(halves, 0) + vgetq_lane_u64(halves, 1));
#else
  unsigned total = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < 16; ++x) {
      const int difference = a[y * stride_a + x] - b[y * stride_b + x];
      total += static_cast<unsigned>(difference < 0 ? -difference : difference);
    }
  }
  return total;
#endif
}

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
