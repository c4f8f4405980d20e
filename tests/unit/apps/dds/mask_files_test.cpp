#include "dds/mask_files.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/instance_masks.hpp"

namespace kinetrace::app {
namespace {

std::vector<std::uint16_t> classes_of(std::vector<std::uint16_t> row, int bit_depth) {
  const int width = static_cast<int>(row.size());
  std::vector<std::uint16_t> classes;
  for (const auto& mask : masks_of({row.data(), width, 1, width}, bit_depth)) {
    classes.push_back(mask.class_id);
  }
  return classes;
}

TEST(MaskFiles, SixteenBitsHoldClassesAndEightBitsInstancesAlone) {
  EXPECT_EQ(classes_of({0, 1001, 2001, 10000}, 16), (std::vector<std::uint16_t>{1, 2, kIgnoreClass}));
  EXPECT_EQ(classes_of({0, 1, 2, 255}, 8), (std::vector<std::uint16_t>{kUnknownClass, kUnknownClass, kIgnoreClass}));
  EXPECT_EQ(classes_of({255}, 16), (std::vector<std::uint16_t>{kUnknownClass})) << "an instance of no class";
}

}  // namespace
}  // namespace kinetrace::app
