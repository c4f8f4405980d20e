// What is recorded is read back as a dataset: images, numbers, times and calibration.
#include "kinetrace/hal/raw_recorder.hpp"

#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <sys/resource.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration_text.hpp"
#include "container_file.hpp"
#include "fake_disk.hpp"
#include "kinetrace/core/crc32.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "rig_for_test.hpp"
#include "sync_log.hpp"
#include "temp_folder.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kPeriod_ns = 33'333'333;

class Raw : public ::testing::Test {
 protected:
  RawRecorderConfig config(RawFormat format, const RigCalibration& rig = rectified_rig()) {
    return {.directory = folder_.path() / "raw",
            .format = format,
            .calibration = rig,
            .rate_hz = 30.0,
            .segment_bytes = 1U << 20U,
            .keep_free_bytes = 0};
  }
  /// Frame `index` of a camera with these images: noise that depends on eye and frame.
  StereoFrame frame(std::int64_t index, const RigCalibration& rig = rectified_rig()) {
    const int width = rig.raw_width_px();
    const int height = rig.raw_height_px();
    StereoFrame frame{.frame_index = index, .timestamp_ns = time_ns(index), .name = {}, .left = {}, .right = {}};
    GrayView* views[] = {&frame.left, &frame.right};
    for (std::size_t eye = 0; eye < 2; ++eye) {
      // A stride of its own: rows do not touch.
      const int stride = width + 5;
      pixels_[eye].resize(static_cast<std::size_t>(stride * height));
      for (std::size_t i = 0; i < pixels_[eye].size(); ++i) {
        pixels_[eye][i] = static_cast<std::uint8_t>((i * 31 + eye * 77 + static_cast<std::size_t>(index) * 13) % 256);
      }
      *views[eye] = {pixels_[eye].data(), width, height, stride};
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
  Result<Dataset> open(DatasetLayout layout) {
    return open_dataset({.layout = layout, .path = folder_.path() / "raw"});
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
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "raw")) {
      paths.push_back(entry.path());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  kinetrace::test::TempFolder folder_;
  std::optional<Arena> arena_;
  std::array<std::vector<std::uint8_t>, 2> pixels_;
};

const std::vector<std::int64_t> kWithGap{3, 4, 5, 9, 10};

TEST_F(Raw, AContainerIsReadBackExactly) {
  record(config(RawFormat::kContainer), kWithGap);
  const Dataset dataset = open(DatasetLayout::kContainer).value();
  EXPECT_TRUE(dataset.notes.empty());
  EXPECT_NEAR(dataset.nominal_rate_hz, 30.0, 0.01);
  EXPECT_EQ(dataset.calibration.rectified->baseline_m, rectified_rig().rectified->baseline_m);
  expect_frames(dataset, kWithGap);
}

TEST_F(Raw, KittisLayoutIsReadBackExactly) {
  record(config(RawFormat::kKittiRaw), kWithGap);
  const Result<Dataset> dataset = open(DatasetLayout::kKittiRaw);
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_TRUE(dataset->calibration.rectified.has_value());
  EXPECT_EQ(dataset->calibration.rectified->baseline_m, rectified_rig().rectified->baseline_m);
  expect_frames(*dataset, kWithGap);
}

TEST_F(Raw, RawImagesStayRawAndAreRectifiedAsBefore) {
  for (const RigCalibration& rig : {radial_rig(), given_rig(), fisheye_rig()}) {
    for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
      const RawRecorderConfig raw = config(format, rig);
      if (format == RawFormat::kKittiRaw && rig.left.lens == LensModel::kEquidistant) {
        const auto recorder = make(raw);
        ASSERT_FALSE(recorder);
        EXPECT_EQ(recorder.error().code, ErrorCode::kUnsupported);
        EXPECT_THAT(recorder.error().message, HasSubstr("container"));
        std::filesystem::remove_all(folder_.path() / "raw");
        continue;
      }
      record(raw, {0, 1});
      const Result<Dataset> dataset =
          open(format == RawFormat::kContainer ? DatasetLayout::kContainer : DatasetLayout::kKittiRaw);
      ASSERT_TRUE(dataset) << dataset.error().message;
      const StereoGeometry before = Rectifier::rectified_geometry(rig, {}).value();
      const StereoGeometry after = Rectifier::rectified_geometry(dataset->calibration, {}).value();
      EXPECT_NEAR(after.fx_px, before.fx_px, 1e-9);
      EXPECT_NEAR(after.cx_px, before.cx_px, 1e-9);
      EXPECT_NEAR(after.baseline_m, before.baseline_m, 1e-12);
      EXPECT_EQ(after.width_px, before.width_px);
      expect_frames(*dataset, {0, 1});
      std::filesystem::remove_all(folder_.path() / "raw");
    }
  }
}

TEST_F(Raw, GoesOnInANewFileAtTheSegmentsSize) {
  // 335 records of 48 x 32 pixels fit a mebibyte.
  std::vector<std::int64_t> indices(1000);
  std::iota(indices.begin(), indices.end(), 0);
  record(config(RawFormat::kContainer), indices);
  const auto files = segments();
  EXPECT_EQ(files.size(), 3U);
  for (const auto& file : files) {
    EXPECT_LE(std::filesystem::file_size(file), 1U << 20U);
  }
  expect_frames(open(DatasetLayout::kContainer).value(), indices);
}

TEST_F(Raw, IsReadableUpToTheLastWholeRecordWhereverItIsCut) {
  record(config(RawFormat::kContainer), {0, 1, 2, 3});
  const std::filesystem::path file = segments().front();
  const std::size_t record_size = record_bytes(48, 32);
  const std::size_t whole = kContainerHeaderBytes + 4 * record_size;
  ASSERT_EQ(std::filesystem::file_size(file), whole);
  for (const std::size_t missing : {std::size_t{1}, std::size_t{1000}, record_size - 1, record_size, record_size + 1,
                                    2 * record_size + 7, 3 * record_size}) {
    std::filesystem::resize_file(file, whole - missing);
    const std::size_t kept = 4 - (missing + record_size - 1) / record_size;
    const Result<Dataset> dataset = open(DatasetLayout::kContainer);
    ASSERT_TRUE(dataset) << dataset.error().message;
    std::vector<std::int64_t> indices(kept);
    std::iota(indices.begin(), indices.end(), 0);
    expect_frames(*dataset, indices);
    const bool is_torn = missing % record_size != 0;
    EXPECT_EQ(dataset->notes.size(), is_torn ? 1U : 0U) << missing << " bytes missing";
  }
  for (const std::size_t left :
       {kContainerHeaderBytes + 5, kContainerHeaderBytes - 1, std::size_t{3}, std::size_t{0}}) {
    std::filesystem::resize_file(file, left);
    EXPECT_EQ(open(DatasetLayout::kContainer).error().code, ErrorCode::kBadFormat) << left;
  }
}

TEST_F(Raw, ATailOfZerosIsNoRecord) {
  // What some file systems leave after a loss of power: the length is there, the content is not.
  record(config(RawFormat::kContainer), {0, 1});
  const std::filesystem::path file = segments().front();
  std::filesystem::resize_file(file, std::filesystem::file_size(file) + 2 * record_bytes(48, 32));
  const Dataset dataset = open(DatasetLayout::kContainer).value();
  EXPECT_EQ(dataset.notes.size(), 1U);
  expect_frames(dataset, {0, 1});
}

TEST_F(Raw, ADamagedRecordCostsOnlyItself) {
  record(config(RawFormat::kContainer), {0, 1, 2, 3});
  {
    std::fstream file(segments().front(), std::ios::in | std::ios::out | std::ios::binary);
    const auto record = [](std::size_t number) {
      return static_cast<std::streamoff>(kContainerHeaderBytes + number * record_bytes(48, 32));
    };
    file.seekp(record(1) + 20);  // In the header: its number or time.
    file.put('x');
    file.seekp(record(2) + 500);  // In the pixels.
    file.put('x').put('y');
  }
  const Dataset dataset = open(DatasetLayout::kContainer).value();
  EXPECT_EQ(dataset.frames.size(), 3U);
  expect_frames(dataset, {0, 3});
}

TEST_F(Raw, ARecordWhoseNumberOrTimeCannotBeIsDamaged) {
  record(config(RawFormat::kContainer), {0, 1, 2, 3});
  {
    std::fstream file(segments().front(), std::ios::in | std::ios::out | std::ios::binary);
    const auto overwrite = [&file](std::size_t number, const RecordHeader& header) {
      std::array<std::byte, kRecordHeaderBytes> bytes{};
      encode_record_header(header, bytes);
      file.seekp(static_cast<std::streamoff>(kContainerHeaderBytes + number * record_bytes(48, 32)));
      file.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    overwrite(1, {-1, 100'000'000, 0});
    overwrite(2, {std::numeric_limits<std::int64_t>::max(), 200'000'000, 0});
    overwrite(3, {3, std::numeric_limits<std::int64_t>::max(), 0});
  }
  const Dataset dataset = open(DatasetLayout::kContainer).value();
  EXPECT_EQ(dataset.frames.size(), 1U);
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_TRUE(dataset.notes[0].starts_with("3 records are damaged")) << dataset.notes[0];
}

TEST_F(Raw, TheNewestFileMayBeCutBeforeItsHeaderIsWhole) {
  record(config(RawFormat::kContainer), {0, 1});
  std::ofstream(folder_.path() / "raw/000001.ktraw") << "KTRAW";
  const Dataset dataset = open(DatasetLayout::kContainer).value();
  EXPECT_EQ(dataset.notes.size(), 1U);
  expect_frames(dataset, {0, 1});
}

TEST_F(Raw, RefusesFilesOfAnotherRecording) {
  record(config(RawFormat::kContainer), {0, 1});
  RawRecorderConfig other = config(RawFormat::kContainer, radial_rig());
  other.directory = folder_.path() / "other";
  record(other, {0});
  std::filesystem::copy_file(folder_.path() / "other/000000.ktraw", folder_.path() / "raw/000001.ktraw");
  EXPECT_EQ(open(DatasetLayout::kContainer).error().code, ErrorCode::kBadFormat);
}

TEST_F(Raw, NeverWritesIntoAFolderWithAnythingInIt) {
  std::filesystem::create_directories(folder_.path() / "raw");
  std::ofstream(folder_.path() / "raw/notes.txt") << "precious";
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
    const auto recorder = make(config(format));
    ASSERT_FALSE(recorder);
    EXPECT_EQ(recorder.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path() / "raw"), {}), 1);
}

TEST_F(Raw, StopsBeforeTheDiskIsFull) {
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
    RawRecorderConfig greedy = config(format);
    greedy.keep_free_bytes = std::uint64_t{1} << 60U;
    const auto recorder = make(greedy).value();
    const Status written = recorder->write(frame(0));
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::kIo);
    EXPECT_THAT(written.error().message, HasSubstr("full"));
    EXPECT_EQ(recorder->write(frame(1)).error().message, written.error().message) << "it takes nothing more";
    EXPECT_EQ(recorder->frames(), 0);
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST_F(Raw, LeavesOthersTheirShareOfTheDisk) {
  constexpr std::uint64_t kShare = std::uint64_t{2} << 20U;
  constexpr std::uint64_t kDisk = kShare + (std::uint64_t{128} << 10U);
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
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
    std::filesystem::remove_all(sharing.directory);
  }
}

/// No file may grow beyond so much, as on a disk that is full: writes come back short, then fail.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    static_cast<void>(std::signal(SIGXFSZ, handler_));
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(Raw, WhatADiskTookBeforeItWasFullIsWhole) {
  const auto recorder = make(config(RawFormat::kContainer)).value();
  const FileSizeLimit limit(kContainerHeaderBytes + 2 * record_bytes(48, 32) + 100);
  EXPECT_TRUE(recorder->write(frame(0)));
  EXPECT_TRUE(recorder->write(frame(1)));
  const Status full = recorder->write(frame(2));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kIo);
  EXPECT_THAT(full.error().message, HasSubstr("000000.ktraw"));
  EXPECT_FALSE(recorder->write(frame(3)));
  EXPECT_EQ(recorder->frames(), 2);
  EXPECT_EQ(std::filesystem::file_size(segments().front()), kContainerHeaderBytes + 2 * record_bytes(48, 32));
  expect_frames(open(DatasetLayout::kContainer).value(), {0, 1});
}

// The images of frame `index` are harder and harder to compress, the right one harder than the left.
TEST_F(Raw, WhatADiskTookBeforeItWasFullIsWholeInKittisLayoutToo) {
  // So that the left image, the right one, or one of the lists of times is what does not fit.
  for (const rlim_t limit : {100U, 130U, 160U, 200U, 240U, 300U, 400U, 700U}) {
    const auto recorder = make(config(RawFormat::kKittiRaw)).value();
    Status full;
    {
      const FileSizeLimit limited(limit);
      for (std::int64_t index = 0; full && index < 1000; ++index) {
        StereoFrame grown = frame(index);
        for (std::size_t eye = 0; eye < 2; ++eye) {
          std::fill(pixels_[eye].begin() + std::min<std::ptrdiff_t>((index / 2) * 8 * static_cast<int>(eye + 1), 1000),
                    pixels_[eye].end(), std::uint8_t{0});
        }
        full = recorder->write(grown);
      }
    }
    ASSERT_FALSE(full) << limit;
    EXPECT_EQ(full.error().code, ErrorCode::kIo);
    const std::int64_t whole = recorder->frames();
    const std::filesystem::path drive = folder_.path() / "raw/drive_0001_sync";
    for (const char* eye : {"image_00", "image_01"}) {
      EXPECT_EQ(std::distance(std::filesystem::directory_iterator(drive / eye / "data"), {}), whole) << limit;
      EXPECT_EQ(std::filesystem::file_size(drive / eye / "timestamps.txt"), 30U * static_cast<std::size_t>(whole));
    }
    if (whole > 0) {
      const Result<Dataset> dataset = open(DatasetLayout::kKittiRaw);
      ASSERT_TRUE(dataset) << limit << dataset.error().message;
      EXPECT_EQ(dataset->frames.complete_count(), static_cast<std::size_t>(whole));
      EXPECT_TRUE(dataset->notes.empty());
    }
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST_F(Raw, KittisLayoutIsReadableWhateverALossOfPowerTookOfItsEnd) {
  using Path = std::filesystem::path;
  const auto shorten = [](const Path& file, std::uintmax_t bytes) {
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - bytes);
  };
  struct Loss {
    const char* what;
    std::function<void(const Path& drive)> happens;
    std::vector<std::int64_t> left;
  };
  const std::vector<Loss> losses{
      {"a right image that never came",
       [](const Path& drive) { std::filesystem::remove(drive / "image_01/data/0000000010.png"); },
       {3, 4, 5, 9}},
      {"both images",
       [](const Path& drive) {
         std::filesystem::remove(drive / "image_00/data/0000000010.png");
         std::filesystem::remove(drive / "image_01/data/0000000010.png");
       },
       {3, 4, 5, 9}},
      {"the content of an image",
       [](const Path& drive) { std::filesystem::resize_file(drive / "image_00/data/0000000010.png", 0); },
       {3, 4, 5, 9}},
      {"half an image", [&](const Path& drive) { shorten(drive / "image_01/data/0000000010.png", 40); }, {3, 4, 5, 9}},
      {"a line of time", [&](const Path& drive) { shorten(drive / "image_00/timestamps.txt", 30); }, kWithGap},
      {"half a line of time", [&](const Path& drive) { shorten(drive / "image_00/timestamps.txt", 13); }, kWithGap},
      {"the end of a line", [&](const Path& drive) { shorten(drive / "frames.txt", 1); }, {3, 4, 5, 9}},
      {"half a line", [&](const Path& drive) { shorten(drive / "frames.txt", 7); }, {3, 4, 5, 9}},
      {"several lines", [&](const Path& drive) { shorten(drive / "frames.txt", 50); }, {3, 4}},
      {"the content behind a length",
       [](const Path& drive) {
         const auto bytes = std::filesystem::file_size(drive / "frames.txt");
         std::filesystem::resize_file(drive / "frames.txt", bytes - 30);
         std::filesystem::resize_file(drive / "frames.txt", bytes);
       },
       {3, 4, 5}},
      {"an unfinished next image",
       [](const Path& drive) { std::ofstream(drive / "image_00/data/0000000011.part") << "PNG"; }, kWithGap},
      {"a next left image without anything else",
       [](const Path& drive) {
         std::filesystem::copy(drive / "image_00/data/0000000010.png", drive / "image_00/data/0000000011.png");
       },
       kWithGap},
      {"many images and no more gaps than would make up for the lines",
       [](const Path& drive) {
         for (const char* eye : {"image_00", "image_01"}) {
           std::filesystem::remove(drive / eye / "data/0000000010.png");
           std::filesystem::remove(drive / eye / "data/0000000009.png");
           std::filesystem::remove(drive / eye / "data/0000000005.png");
         }
       },
       {3, 4}},
  };
  for (const Loss& loss : losses) {
    SCOPED_TRACE(loss.what);
    record(config(RawFormat::kKittiRaw), kWithGap);
    loss.happens(folder_.path() / "raw/drive_0001_sync");
    const Result<Dataset> dataset = open(DatasetLayout::kKittiRaw);
    ASSERT_TRUE(dataset) << dataset.error().message;
    expect_frames(*dataset, loss.left);
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST_F(Raw, WithoutAWholeFrameThereIsNoRecording) {
  record(config(RawFormat::kKittiRaw), {0});
  const std::filesystem::path times = folder_.path() / "raw/drive_0001_sync/frames.txt";
  std::filesystem::resize_file(times, std::filesystem::file_size(times) - 1);
  const Result<Dataset> dataset = open(DatasetLayout::kKittiRaw);
  ASSERT_FALSE(dataset);
  EXPECT_EQ(dataset.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(dataset.error().message, HasSubstr("frames.txt"));
}

TEST_F(Raw, FilesAndTheirNamesLast) {
  using ::testing::Contains;
  using ::testing::ElementsAre;
  using ::testing::Pair;
  const std::string folder = (folder_.path() / "raw").string();
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
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
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST_F(Raw, OpensMoreFilesThanAProgramMayHaveOpen) {
  std::vector<std::int64_t> indices(64);
  std::iota(indices.begin(), indices.end(), 0);
  record(config(RawFormat::kContainer), indices);
  // A file for each frame, as long recordings in small segments have.
  const std::filesystem::path first = segments().front();
  std::ifstream stream(first, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  for (const std::int64_t index : indices) {
    char name[32];
    std::snprintf(name, sizeof(name), "1%05d.ktraw", static_cast<int>(index));
    const std::size_t size = record_bytes(48, 32);
    std::ofstream(folder_.path() / "raw" / name, std::ios::binary)
        << bytes.substr(0, kContainerHeaderBytes)
        << bytes.substr(kContainerHeaderBytes + static_cast<std::size_t>(index) * size, size);
  }
  std::filesystem::remove(first);
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit few{32, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &few);
  const Result<Dataset> dataset = open(DatasetLayout::kContainer);
  EXPECT_TRUE(dataset) << dataset.error().message;
  if (dataset) {
    expect_frames(*dataset, indices);
  }
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST_F(Raw, RefusesImagesWithWidthAndHeightExchanged) {
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
    const auto recorder = make(config(format)).value();
    StereoFrame turned = frame(0);
    for (GrayView* image : {&turned.left, &turned.right}) {
      *image = {image->data, image->height, image->width, image->height};
    }
    EXPECT_EQ(recorder->write(turned).error().code, ErrorCode::kInvalidArgument);
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST_F(Raw, RefusesAnImageOfAnotherSize) {
  for (const RawFormat format : {RawFormat::kContainer, RawFormat::kKittiRaw}) {
    const auto recorder = make(config(format)).value();
    StereoFrame odd = frame(0);
    odd.right.height -= 1;
    EXPECT_EQ(recorder->write(odd).error().code, ErrorCode::kInvalidArgument);
    std::filesystem::remove_all(folder_.path() / "raw");
  }
}

TEST(CalibrationText, IsReadBackToTheSameNumbers) {
  for (const RigCalibration& rig : {radial_rig(), fisheye_rig(), given_rig(), rectified_rig()}) {
    const RigCalibration back = parse_calibration_text(calibration_text(rig), "file").value();
    EXPECT_EQ(calibration_text(back), calibration_text(rig));
    EXPECT_EQ(back.source, "file");
    EXPECT_EQ(back.given.has_value(), rig.given.has_value());
    EXPECT_EQ(back.raw_width_px(), rig.raw_width_px());
    EXPECT_EQ(back.left.distortion, rig.left.distortion);
  }
  EXPECT_EQ(parse_calibration_text("", "file").error().code, ErrorCode::kBadCalibration);
  EXPECT_EQ(parse_calibration_text("left: 1 2\nright: x\n", "file").error().code, ErrorCode::kBadCalibration);
}

TEST(Crc32, IsThatOfTheStandard) {
  const std::string_view check = "123456789";
  EXPECT_EQ(Crc32().update(std::as_bytes(std::span(check))).value(), 0xCBF43926U);
  // The same in pieces of every length.
  const std::string text = "the quick brown fox jumps over the lazy dog";
  const std::uint32_t whole = Crc32().update(std::as_bytes(std::span(text))).value();
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_EQ(Crc32().update(bytes.first(cut)).update(bytes.subspan(cut)).value(), whole) << cut;
  }
  EXPECT_EQ(Crc32().value(), 0U);
}

}  // namespace
}  // namespace kinetrace::hal::test
