// Reading an image takes no memory of our own: only the codecs' working memory, which is counted as foreign.
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "temp_folder.hpp"

namespace kinetrace::imaging {
namespace {

TEST(ImageReaderAllocations, AreAllForeign) {
  ASSERT_TRUE(allocation_counting_available());
  const kinetrace::test::TempFolder folder;
  const std::string gray = folder.file("gray.png");
  const std::string labels = folder.file("labels.png");
  const std::vector<std::uint16_t> pixels(64 * 48, 1001);
  const std::vector<std::uint8_t> gray_pixels(64 * 48, 77);
  ASSERT_TRUE(write_png_gray8(gray.c_str(), {gray_pixels.data(), 64, 48, 64}));
  ASSERT_TRUE(write_png_gray16(labels.c_str(), {pixels.data(), 64, 48, 64}));
  Arena arena(std::size_t{1} << 20);
  auto reader = ImageReader::create({.max_width_px = 64, .max_height_px = 48, .max_file_bytes = 1 << 16}, arena);
  ASSERT_TRUE(reader);
  const MutableGrayView target = take_image<std::uint8_t>(arena, 64, 48);
  const ImageView<std::uint16_t> label_target = take_image<std::uint16_t>(arena, 64, 48);

  const AllocationCounts before = allocation_counts();
  const bool read = reader->read_gray(gray.c_str(), target).has_value() &&
                    reader->read_gray16(labels.c_str(), label_target).has_value();
  const AllocationCounts after = allocation_counts();

  EXPECT_TRUE(read);
  EXPECT_EQ(after.own, before.own);
  EXPECT_GT(after.foreign, before.foreign);
  EXPECT_EQ(target.at(63, 47), 77);
  EXPECT_EQ(label_target.at(63, 47), 1001);
}

}  // namespace
}  // namespace kinetrace::imaging
