// Common behaviour of both recording formats.
#include "kinetrace/hal/raw_recorder.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fake_disk.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "raw_recording_for_test.hpp"
#include "sync_log.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Raw, RawImagesStayRawAndAreRectifiedAsBefore) {
  for (const RigCalibration& rig : {radial_rig(), given_rig(), fisheye_rig()}) {
    for (const RawFormat format : kRawFormats) {
      const RawRecorderConfig recorded = config(format, rig);
      if (format == RawFormat::kKittiRaw && rig.left.lens == LensModel::kEquidistant) {
        const auto recorder = make(recorded);
        ASSERT_FALSE(recorder);
        EXPECT_EQ(recorder.error().code, ErrorCode::kUnsupported);
        EXPECT_THAT(recorder.error().message, HasSubstr("container"));
        EXPECT_FALSE(std::filesystem::exists(raw()));
        continue;
      }
      record(recorded, {0, 1});
      const Result<Dataset> dataset = open(format);
      ASSERT_TRUE(dataset) << dataset.error().message;
      const StereoGeometry before = Rectifier::rectified_geometry(rig, {}).value();
      const StereoGeometry after = Rectifier::rectified_geometry(dataset->calibration, {}).value();
      EXPECT_NEAR(after.fx_px, before.fx_px, 1e-9);
      EXPECT_NEAR(after.cx_px, before.cx_px, 1e-9);
      EXPECT_NEAR(after.baseline_m, before.baseline_m, 1e-12);
      EXPECT_EQ(after.width_px, before.width_px);
      expect_frames(*dataset, {0, 1});
      clear();
    }
  }
}

TEST_F(Raw, NeverWritesIntoAFolderWithAnythingInIt) {
  std::filesystem::create_directories(raw());
  std::ofstream(raw() / "notes.txt") << "precious";
  for (const RawFormat format : kRawFormats) {
    const auto recorder = make(config(format));
    ASSERT_FALSE(recorder);
    EXPECT_EQ(recorder.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(raw()), {}), 1);
}

TEST_F(Raw, StopsBeforeTheDiskIsFull) {
  for (const RawFormat format : kRawFormats) {
    RawRecorderConfig greedy = config(format);
    greedy.keep_free_bytes = std::uint64_t{1} << 60U;
    const auto recorder = make(greedy).value();
    const Status written = recorder->write(frame(0));
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::kIo);
    EXPECT_THAT(written.error().message, HasSubstr("full"));
    EXPECT_EQ(recorder->write(frame(1)).error().message, written.error().message) << "it takes nothing more";
    EXPECT_EQ(recorder->frames(), 0);
    clear();
  }
}

TEST_F(Raw, LeavesOthersTheirShareOfTheDisk) {
  constexpr std::uint64_t kShare = std::uint64_t{2} << 20U;
  constexpr std::uint64_t kDisk = kShare + (std::uint64_t{128} << 10U);
  for (const RawFormat format : kRawFormats) {
    RawRecorderConfig sharing = config(format);
    sharing.keep_free_bytes = kShare;
    const auto recorder = make(sharing).value();
    const FakeDisk disk(sharing.directory, kDisk);
    Status written;
    std::int64_t index = 0;
    while (written && index < 10'000) {
      written = recorder->write(frame(index++));
    }
    ASSERT_FALSE(written);
    EXPECT_THAT(written.error().message, HasSubstr("2 MiB are kept free"));
    EXPECT_GE(disk.free_bytes(), kShare);
    EXPECT_LE(disk.free_bytes(), kShare + 32768) << "what there is to be used is used";
    EXPECT_GT(recorder->frames(), 10);
    clear();
  }
}

TEST_F(Raw, FilesAndTheirNamesLast) {
  using ::testing::Contains;
  using ::testing::ElementsAre;
  using ::testing::Pair;
  const std::string folder = (raw()).string();
  for (const RawFormat format : kRawFormats) {
    static_cast<void>(take_syncs());
    const auto recorder = make(config(format)).value();
    EXPECT_THAT(take_syncs(), Contains(Pair("disk", folder))) << "the folder, the calibration and the first header";
    const bool is_container = format == RawFormat::kContainer;
    // 335 records of 48 x 32 pixels fill the first file.
    for (std::int64_t index = 0; is_container && index < 336; ++index) {
      ASSERT_TRUE(recorder->write(frame(index)));
    }
    if (is_container) {
      EXPECT_THAT(take_syncs(), ElementsAre(Pair("data", folder + "/000000.ktraw"), Pair("file", folder)));
    }
    ASSERT_TRUE(recorder->write(frame(336)));
    ASSERT_TRUE(recorder->sync());
    EXPECT_THAT(take_syncs(), ElementsAre(is_container ? Pair("data", folder + "/000001.ktraw")
                                                       : Pair("disk", folder + "/drive_0001_sync")))
        << "once";
    clear();
  }
}

TEST_F(Raw, RefusesImagesWithWidthAndHeightExchanged) {
  for (const RawFormat format : kRawFormats) {
    const auto recorder = make(config(format)).value();
    StereoFrame turned = frame(0);
    for (GrayView* image : {&turned.left, &turned.right}) {
      *image = {image->data, image->height, image->width, image->height};
    }
    EXPECT_EQ(recorder->write(turned).error().code, ErrorCode::kInvalidArgument);
    clear();
  }
}

TEST_F(Raw, RefusesAnImageOfAnotherSize) {
  for (const RawFormat format : kRawFormats) {
    const auto recorder = make(config(format)).value();
    StereoFrame odd = frame(0);
    odd.right.height -= 1;
    EXPECT_EQ(recorder->write(odd).error().code, ErrorCode::kInvalidArgument);
    clear();
  }
}

}  // namespace
}  // namespace kinetrace::hal::test
