// Recordings by RawRecorder, read back as a dataset.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "formats/container_file.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/raw_recorder.hpp"
#include "rig_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::hal::test {

inline constexpr RawFormat kRawFormats[] = {RawFormat::kContainer, RawFormat::kKittiRaw};
inline constexpr std::int64_t kPeriod_ns = 33'333'333;
/// Of the images of rectified_rig().
inline const std::size_t kRecordBytes = record_bytes(48, 32);
inline const std::vector<std::int64_t> kWithGap{3, 4, 5, 9, 10};

class Raw : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path raw() const { return folder_.path() / "raw"; }
  void clear() { std::filesystem::remove_all(raw()); }
  RawRecorderConfig config(RawFormat format, const RigCalibration& rig = rectified_rig()) {
    return {.directory = raw(),
            .format = format,
            .calibration = rig,
            .rate_hz = 30.0,
            .segment_bytes = 1U << 20U,
            .keep_free_bytes = 0};
  }
  /// Frame `index` of a camera with these images: noise that depends on camera and frame.
  StereoFrame frame(std::int64_t index, const RigCalibration& rig = rectified_rig()) {
    const int width = rig.raw_width_px();
    const int height = rig.raw_height_px();
    StereoFrame frame{.frame_index = index, .timestamp_ns = time_ns(index), .name = {}, .left = {}, .right = {}};
    GrayView* views[] = {&frame.left, &frame.right};
    for (std::size_t view = 0; view < 2; ++view) {
      // A stride of its own: rows do not touch.
      const int stride = width + 5;
      pixels_[view].resize(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height));
      for (std::size_t i = 0; i < pixels_[view].size(); ++i) {
        pixels_[view][i] = static_cast<std::uint8_t>((i * 31 + view * 77 + static_cast<std::size_t>(index) * 13) % 256);
      }
      *views[view] = {pixels_[view].data(), width, height, stride};
    }
    return frame;
  }
  static std::int64_t time_ns(std::int64_t index) { return 5'000'000'000 + index * kPeriod_ns; }

  Result<std::unique_ptr<RawRecorder>> make(const RawRecorderConfig& config) {
    arena_.emplace(RawRecorder::required_bytes(config) + Arena::kAlignment);
    return RawRecorder::create(config, *arena_);
  }
  void record(const RawRecorderConfig& config, const std::vector<std::int64_t>& indices) {
    const auto recorder = make(config).value();
    for (const std::int64_t index : indices) {
      const Status written = recorder->write(frame(index, config.calibration));
      ASSERT_TRUE(written) << written.error().message;
    }
    EXPECT_TRUE(recorder->sync());
    EXPECT_EQ(recorder->frames(), static_cast<std::int64_t>(indices.size()));
  }
  Result<Dataset> open(RawFormat format) {
    const bool is_container = format == RawFormat::kContainer;
    return open_dataset({.layout = is_container ? DatasetLayout::kContainer : DatasetLayout::kKittiRaw, .path = raw()});
  }

  /// Plays the dataset and expects exactly these frames, pixel for pixel, with the right times between them.
  void expect_frames(const Dataset& dataset, const std::vector<std::int64_t>& indices) {
    Arena arena(FileStereoCamera::required_bytes(dataset, {}));
    auto camera = FileStereoCamera::create(dataset, {}, arena);
    ASSERT_TRUE(camera) << camera.error().message;
    ASSERT_TRUE(camera->open() && camera->start());
    std::optional<std::int64_t> first_ns;
    for (const std::int64_t index : indices) {
      const Result<StereoFrame> read = camera->next(std::chrono::milliseconds(1));
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->frame_index, index);
      first_ns = first_ns.value_or(read->timestamp_ns - time_ns(index));
      EXPECT_EQ(read->timestamp_ns - *first_ns, time_ns(index));
      const StereoFrame expected = frame(index, dataset.calibration);
      for (const auto& [got, wanted] : {std::pair{read->left, expected.left}, std::pair{read->right, expected.right}}) {
        ASSERT_EQ(got.width, wanted.width);
        for (int y = 0; y < got.height; ++y) {
          ASSERT_TRUE(std::equal(got.row(y), got.row(y) + got.width, wanted.row(y))) << index << ", row " << y;
        }
      }
    }
    EXPECT_EQ(camera->next(std::chrono::milliseconds(1)).error().code, ErrorCode::kEndOfStream);
  }
  std::vector<std::filesystem::path> segments() {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(raw())) {
      paths.push_back(entry.path());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  kinetrace::test::TempFolder folder_;
  std::optional<Arena> arena_;
  std::array<std::vector<std::uint8_t>, 2> pixels_;
};

}  // namespace kinetrace::hal::test
