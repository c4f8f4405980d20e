// Plain loops that the compiler vectorises, except the gathering of source pixels.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "rectification/lookup_kernel.hpp"

namespace kinetrace::hal::KINETRACE_KERNEL_ISA {
namespace {

using Byte = std::uint8_t;
using Word = std::uint16_t;

static_assert(std::endian::native == std::endian::little, "two pixels read as one word: the left one is the low byte");

constexpr int kBlock = 64;
using Words = std::array<Word, kBlock>;

/// Pixels (x, y) and (x + 1, y) of each entry, and the two below them.
struct Neighbours {
  Words upper;
  Words lower;
};

void collect(const Byte* source, std::ptrdiff_t stride, const std::int16_t* positions, int count, Neighbours& found) {
  for (int i = 0; i < count; ++i, positions += 2) {
    const Byte* pixel = source + positions[1] * stride + positions[0];
    std::memcpy(&found.upper[static_cast<std::size_t>(i)], pixel, sizeof(Word));
    std::memcpy(&found.lower[static_cast<std::size_t>(i)], pixel + stride, sizeof(Word));
  }
}

// Weighted sum of the lower and the upper byte: at most 255 * 32.
Word between(Word pair, Word fraction) {
  constexpr Word kSteps = kLookupSteps;
  return static_cast<Word>((pair & 0xFF) * static_cast<Word>(kSteps - fraction) + (pair >> 8) * fraction);
}

void blend(const Neighbours& from, const Word* __restrict fractions, int count, Byte* __restrict target) {
  constexpr std::uint32_t kHalf = kLookupSteps * kLookupSteps / 2;
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto fx = static_cast<Word>(fractions[i] & 0xFF);
    const auto fy = static_cast<Word>(fractions[i] >> 8);
    const std::uint32_t upper = between(from.upper[at], fx);
    const std::uint32_t lower = between(from.lower[at], fx);
    target[i] = static_cast<Byte>((upper * static_cast<Word>(kLookupSteps - fy) + lower * fy + kHalf) /
                                  (kLookupSteps * kLookupSteps));
  }
}

void look_up(const Byte* source, std::ptrdiff_t stride, const LookupRow& row, Byte* target) {
  Neighbours neighbours;
  for (int first = 0; first < row.width; first += kBlock) {
    const int count = std::min(kBlock, row.width - first);
    collect(source, stride, row.positions + 2 * static_cast<std::ptrdiff_t>(first), count, neighbours);
    blend(neighbours, row.fractions + first, count, target + first);
  }
}

}  // namespace

extern const LookupKernel kLookup;
const LookupKernel kLookup = &look_up;

}  // namespace kinetrace::hal::KINETRACE_KERNEL_ISA
