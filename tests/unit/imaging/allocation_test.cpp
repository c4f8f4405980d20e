// Reading an image allocates no memory of our own: only the codecs' working memory, which is counted as foreign.
#include <filesystem>
#include <fstream>
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

TEST(ImageReaderAllocations, AreNoneForFilesThatCannotBeRead) {
  ASSERT_TRUE(allocation_counting_available());
  const kinetrace::test::TempFolder folder;
  const std::vector<std::uint8_t> pixels(128 * 96, 77);
  ASSERT_TRUE(write_png_gray8(folder.file("cut.png").c_str(), {pixels.data(), 64, 48, 64}));
  std::filesystem::resize_file(folder.file("cut.png"), 60);
  ASSERT_TRUE(write_png_gray8(folder.file("large.png").c_str(), {pixels.data(), 128, 96, 128}));
  std::ofstream(folder.file("empty.png"));
  std::ofstream(folder.file("text.png")) << "not a picture at all";
  std::ofstream(folder.file("cut.pgm")) << "P5 64 48 255\n";
  std::ofstream(folder.file("cut.jpg")) << "\xff\xd8\xff";
  std::filesystem::create_directory(folder.file("folder.png"));
  Arena arena(std::size_t{1} << 20);
  auto reader = ImageReader::create({.max_width_px = 64, .max_height_px = 48, .max_file_bytes = 1 << 16}, arena);
  ASSERT_TRUE(reader);
  const MutableGrayView target = take_image<std::uint8_t>(arena, 64, 48);
  const ImageView<std::uint16_t> labels = take_image<std::uint16_t>(arena, 64, 48);

  for (const char* name :
       {"cut.png", "large.png", "empty.png", "text.png", "cut.pgm", "cut.jpg", "folder.png", "none.png"}) {
    const std::string path = folder.file(name);
    const AllocationCounts before = allocation_counts();
    const bool read =
        reader->read_gray(path.c_str(), target).has_value() || reader->read_gray16(path.c_str(), labels).has_value();
    EXPECT_EQ(allocation_counts().own, before.own) << name;
    EXPECT_FALSE(read) << name;
  }
}

}  // namespace
}  // namespace kinetrace::imaging
