#include "rectification/lookup_kernel.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

constexpr std::ptrdiff_t kStride = 51;  // Wider than the image.
constexpr int kWidth = 47;
constexpr int kHeight = 31;

struct Table {
  std::vector<std::int16_t> positions;
  std::vector<std::uint16_t> fractions;

  void add(int x, int y, int fx, int fy) {
    positions.push_back(static_cast<std::int16_t>(x));
    positions.push_back(static_cast<std::int16_t>(y));
    fractions.push_back(static_cast<std::uint16_t>(fx + 256 * fy));
  }
  [[nodiscard]] LookupRow row() const {
    return {positions.data(), fractions.data(), static_cast<int>(fractions.size())};
  }
};

std::vector<std::uint8_t> noise() {
  std::mt19937 random(1);
  std::vector<std::uint8_t> pixels(kStride * kHeight);
  for (std::uint8_t& pixel : pixels) {
    pixel = static_cast<std::uint8_t>(random());
  }
  return pixels;
}

// By definition, in exact arithmetic.
int expected(const std::vector<std::uint8_t>& pixels, const Table& table, std::size_t i) {
  const int x = table.positions[2 * i];
  const int y = table.positions[2 * i + 1];
  const int fx = table.fractions[i] % 256;
  const int fy = table.fractions[i] / 256;
  const auto at = [&pixels](int column, int row) {
    return pixels[static_cast<std::size_t>(row * kStride) + static_cast<std::size_t>(column)];
  };
  const int sum =
      (32 - fy) * ((32 - fx) * at(x, y) + fx * at(x + 1, y)) + fy * ((32 - fx) * at(x, y + 1) + fx * at(x + 1, y + 1));
  return (sum + 512) / 1024;
}

TEST(LookupKernel, BlendsTheFourPixelsAroundEachEntry) {
  const std::vector<std::uint8_t> pixels = noise();
  for (const LookupKernel kernel : {lookup_kernel(), baseline_lookup_kernel()}) {
    for (const int width : {0, 1, 63, 64, 65, 200}) {
      std::mt19937 random(static_cast<unsigned>(width));
      const auto up_to = [&random](int last) { return std::uniform_int_distribution<int>(0, last)(random); };
      Table table;
      for (int i = 0; i < width; ++i) {
        table.add(up_to(kWidth - 2), up_to(kHeight - 2), up_to(kLookupSteps), up_to(kLookupSteps));
      }
      std::vector<std::uint8_t> target(static_cast<std::size_t>(width) + 1, 77);
      kernel(pixels.data(), kStride, table.row(), target.data());
      for (std::size_t i = 0; i + 1 < target.size(); ++i) {
        ASSERT_EQ(target[i], expected(pixels, table, i)) << i << " of " << width;
      }
      EXPECT_EQ(target.back(), 77) << "nothing is written beyond the row";
    }
  }
}

TEST(LookupKernel, EndsOfAFractionAreThePixelsThemselves) {
  const std::vector<std::uint8_t> pixels = noise();
  for (const LookupKernel kernel : {lookup_kernel(), baseline_lookup_kernel()}) {
    Table table;
    table.add(5, 7, 0, 0);
    table.add(kWidth - 2, 7, kLookupSteps, 0);
    table.add(5, kHeight - 2, 0, kLookupSteps);
    table.add(kWidth - 2, kHeight - 2, kLookupSteps, kLookupSteps);
    std::vector<std::uint8_t> target(4);
    kernel(pixels.data(), kStride, table.row(), target.data());
    EXPECT_EQ(target[0], pixels[7 * kStride + 5]);
    EXPECT_EQ(target[1], pixels[7 * kStride + kWidth - 1]);
    EXPECT_EQ(target[2], pixels[(kHeight - 1) * kStride + 5]);
    EXPECT_EQ(target[3], pixels[(kHeight - 1) * kStride + kWidth - 1]);
  }
}

}  // namespace
}  // namespace kinetrace::hal
