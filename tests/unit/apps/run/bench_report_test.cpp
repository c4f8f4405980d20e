#include "run/bench_report.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace::app {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

BenchReport report_of(double track_ms, double frame_ms) {
  return {.version = "1.2.3",
          .processor = "Some CPU",
          .kernels = "baseline",
          .dataset = "kitti-raw:drive",
          .width_px = 640,
          .height_px = 480,
          .repeats = 2,
          .frame = {.count = 80, .median_ms = frame_ms, .p95_ms = 9.0, .max_ms = 10.0},
          .stages = {{"track_features", {.count = 80, .median_ms = track_ms, .p95_ms = 5.0, .max_ms = 6.0}},
                     {"publish", {.count = 80, .median_ms = 0.0, .p95_ms = 0.0, .max_ms = 0.0}}}};
}

TEST(BenchReport, ComesBackFromItsFile) {
  const test::TempFolder folder;
  std::ofstream(folder.file("bench.json")) << bench_json(report_of(4.0, 8.0));
  const Result<BenchReport> read = read_bench_report(folder.file("bench.json"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(bench_json(*read), bench_json(report_of(4.0, 8.0)));
  EXPECT_EQ(read->stages[0].first, "track_features");
  EXPECT_EQ(read->frame.count, 80U);
}

TEST(BenchReport, IsWrittenForARecordingWhoseNameIsNotUtf8) {
  BenchReport report = report_of(4.0, 8.0);
  report.dataset = "kitti-raw:drive\xff";
  EXPECT_THAT(bench_json(report), HasSubstr("\"kitti-raw:drive\xef\xbf\xbd\""));
}

TEST(BenchReport, WhatIsNoReportIsNamed) {
  const test::TempFolder folder;
  const auto absent = read_bench_report(folder.file("none.json"));
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, ErrorCode::kNotFound);
  for (const char* text : {"", "[]", "{\"version\": 3}"}) {
    std::ofstream(folder.file("bad.json")) << text;
    const auto bad = read_bench_report(folder.file("bad.json"));
    ASSERT_FALSE(bad) << text;
    EXPECT_EQ(bad.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(bad.error().message, HasSubstr("bad.json"));
  }
}

TEST(BenchReport, TheTableComparesMedians) {
  const BenchReport now = report_of(3.0, 8.8);
  EXPECT_THAT(bench_table(now, nullptr), Not(HasSubstr("before")));
  EXPECT_THAT(bench_table(now, nullptr), ContainsRegex("track_features +3\\.000 +5\\.000 +6\\.000\n"));
  BenchReport before = report_of(4.0, 8.0);
  before.stages.pop_back();
  const std::string table = bench_table(now, &before);
  EXPECT_THAT(table, ContainsRegex("track_features .* 4\\.000 +-25\\.0 %"));
  EXPECT_THAT(table, ContainsRegex("frame .* 8\\.000 +\\+10\\.0 %"));
  EXPECT_THAT(table, ContainsRegex("publish +0\\.000 +0\\.000 +0\\.000\n")) << "a stage that is new";
}

}  // namespace
}  // namespace kinetrace::app
