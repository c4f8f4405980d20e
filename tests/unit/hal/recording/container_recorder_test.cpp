// Containers: read back exactly, up to the first damage.
#include <cstdio>
#include <fstream>
#include <limits>
#include <numeric>
#include <string>
#include <sys/resource.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fake_disk.hpp"
#include "raw_recording_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Raw, AContainerIsReadBackExactly) {
  record(config(RawFormat::kContainer), kWithGap);
  const Dataset dataset = open(RawFormat::kContainer).value();
  EXPECT_TRUE(dataset.notes.empty());
  EXPECT_NEAR(dataset.nominal_rate_hz, 30.0, 0.01);
  EXPECT_EQ(dataset.calibration.rectified->baseline_m, rectified_rig().rectified->baseline_m);
  expect_frames(dataset, kWithGap);
}

TEST_F(Raw, ContinuesInANewFileAtTheSegmentsSize) {
  // 335 records of 48 x 32 pixels fit a mebibyte.
  std::vector<std::int64_t> indices(1000);
  std::iota(indices.begin(), indices.end(), 0);
  record(config(RawFormat::kContainer), indices);
  const auto files = segments();
  EXPECT_EQ(files.size(), 3U);
  for (const auto& file : files) {
    EXPECT_LE(std::filesystem::file_size(file), 1U << 20U);
  }
  expect_frames(open(RawFormat::kContainer).value(), indices);
}

TEST_F(Raw, IsReadableUpToTheLastWholeRecordWhereverItIsCut) {
  record(config(RawFormat::kContainer), {0, 1, 2, 3});
  const std::filesystem::path file = segments().front();
  const std::size_t record_size = kRecordBytes;
  const std::size_t whole = kContainerHeaderBytes + 4 * record_size;
  ASSERT_EQ(std::filesystem::file_size(file), whole);
  for (const std::size_t missing : {std::size_t{1}, std::size_t{1000}, record_size - 1, record_size, record_size + 1,
                                    2 * record_size + 7, 3 * record_size}) {
    std::filesystem::resize_file(file, whole - missing);
    const std::size_t kept = 4 - (missing + record_size - 1) / record_size;
    const Result<Dataset> dataset = open(RawFormat::kContainer);
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
    EXPECT_EQ(open(RawFormat::kContainer).error().code, ErrorCode::kBadFormat) << left;
  }
}

TEST_F(Raw, ATailOfZerosIsNoRecord) {
  // Some file systems leave this after a loss of power: the file's length without its content.
  record(config(RawFormat::kContainer), {0, 1});
  const std::filesystem::path file = segments().front();
  std::filesystem::resize_file(file, std::filesystem::file_size(file) + 2 * kRecordBytes);
  const Dataset dataset = open(RawFormat::kContainer).value();
  EXPECT_EQ(dataset.notes.size(), 1U);
  expect_frames(dataset, {0, 1});
}

TEST_F(Raw, ADamagedRecordCostsOnlyItself) {
  record(config(RawFormat::kContainer), {0, 1, 2, 3});
  {
    std::fstream file(segments().front(), std::ios::in | std::ios::out | std::ios::binary);
    const auto record = [](std::size_t number) {
      return static_cast<std::streamoff>(kContainerHeaderBytes + number * kRecordBytes);
    };
    file.seekp(record(1) + 20);  // In the header: its number or time.
    file.put('x');
    file.seekp(record(2) + 500);  // In the pixels.
    file.put('x').put('y');
  }
  const Dataset dataset = open(RawFormat::kContainer).value();
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
      file.seekp(static_cast<std::streamoff>(kContainerHeaderBytes + number * kRecordBytes));
      file.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    overwrite(1, {-1, 100'000'000, 0});
    overwrite(2, {std::numeric_limits<std::int64_t>::max(), 200'000'000, 0});
    overwrite(3, {3, std::numeric_limits<std::int64_t>::max(), 0});
  }
  const Dataset dataset = open(RawFormat::kContainer).value();
  EXPECT_EQ(dataset.frames.size(), 1U);
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_TRUE(dataset.notes[0].starts_with("3 records are damaged")) << dataset.notes[0];
}

TEST_F(Raw, TheNewestFileMayBeCutBeforeItsHeaderIsWhole) {
  record(config(RawFormat::kContainer), {0, 1});
  std::ofstream(raw() / "000001.ktraw") << "KTRAW";
  const Dataset dataset = open(RawFormat::kContainer).value();
  EXPECT_EQ(dataset.notes.size(), 1U);
  expect_frames(dataset, {0, 1});
}

TEST_F(Raw, RefusesFilesOfAnotherRecording) {
  record(config(RawFormat::kContainer), {0, 1});
  RawRecorderConfig other = config(RawFormat::kContainer, radial_rig());
  other.directory = folder_.path() / "other";
  record(other, {0});
  std::filesystem::copy_file(folder_.path() / "other/000000.ktraw", raw() / "000001.ktraw");
  EXPECT_EQ(open(RawFormat::kContainer).error().code, ErrorCode::kBadFormat);
}

TEST_F(Raw, WhatADiskTookBeforeItWasFullIsWhole) {
  const auto recorder = make(config(RawFormat::kContainer)).value();
  const FileSizeLimit limit(kContainerHeaderBytes + 2 * kRecordBytes + 100);
  EXPECT_TRUE(recorder->write(frame(0)));
  EXPECT_TRUE(recorder->write(frame(1)));
  const Status full = recorder->write(frame(2));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kIo);
  EXPECT_THAT(full.error().message, HasSubstr("000000.ktraw"));
  EXPECT_FALSE(recorder->write(frame(3)));
  EXPECT_EQ(recorder->frames(), 2);
  EXPECT_EQ(std::filesystem::file_size(segments().front()), kContainerHeaderBytes + 2 * kRecordBytes);
  expect_frames(open(RawFormat::kContainer).value(), {0, 1});
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
    const std::size_t size = kRecordBytes;
    std::ofstream(raw() / name, std::ios::binary)
        << bytes.substr(0, kContainerHeaderBytes)
        << bytes.substr(kContainerHeaderBytes + static_cast<std::size_t>(index) * size, size);
  }
  std::filesystem::remove(first);
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit few{32, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &few);
  const Result<Dataset> dataset = open(RawFormat::kContainer);
  EXPECT_TRUE(dataset) << dataset.error().message;
  if (dataset) {
    expect_frames(*dataset, indices);
  }
  setrlimit(RLIMIT_NOFILE, &before);
}

}  // namespace
}  // namespace kinetrace::hal::test
