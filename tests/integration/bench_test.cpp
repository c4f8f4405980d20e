// The command `kinetrace bench` as a user meets it.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class Bench : public ::testing::Test {
 protected:
  void SetUp() override { recording_.write(); }
  [[nodiscard]] ProgramResult bench(std::vector<std::string> more) const {
    more.insert(more.begin(), {"bench", "--dataset", recording_.dataset(), "--repeat", "2"});
    return run_kinetrace(more);
  }
  /// The times of this recording, as --out writes them.
  [[nodiscard]] json measured() const {
    const ProgramResult result = bench({"--out", file_});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(text_of(file_), nullptr, false);
  }
  /// An impossible comparison is refused before the recording is opened, hence before any waiting.
  static void expect_refused(const std::string& against, int exit_code, const std::string& culprit) {
    expect_refusal(run_kinetrace({"bench", "--dataset", "folder:nowhere", "--against", against}), exit_code, culprit);
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::string file_ = scratch_.file("bench.json");
};

TEST_F(Bench, TimesStagesAndLeavesOnlyTheFileItIsAskedFor) {
  const ProgramResult result = bench({"--out", file_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("track_features"), HasSubstr("12 frames"), HasSubstr("frame ")));
  EXPECT_THAT(result.out, Not(HasSubstr("before")));
  const json written = json::parse(text_of(file_));
  EXPECT_EQ(written["frame_ms"]["count"], 2 * recording_.frames);
  EXPECT_GT(written["stage_ms"]["track_features"]["median"], 0.0);
  const std::filesystem::directory_iterator entries(scratch_.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 2) << "the recording and the file";
}

TEST_F(Bench, ReplacesTimesOnly) {
  const ProgramResult first = bench({"--out", file_});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(bench({"--out", file_}).exit_code, 0);
  // Before the recording is opened, hence before any waiting.
  std::ofstream(file_) << "frame,ms\n1,20\n";
  expect_refusal(run_kinetrace({"bench", "--dataset", "folder:nowhere", "--out", file_}), kCannotCreate,
                 file_ + ": is there already, and is no report of `kinetrace bench`; name another place");
  EXPECT_EQ(text_of(file_), "frame,ms\n1,20\n");
  const std::string nowhere = scratch_.path() / "none" / "bench.json";
  expect_refusal(run_kinetrace({"bench", "--dataset", "folder:nowhere", "--out", nowhere}), kIo,
                 nowhere + ": cannot be written (No such file or directory); check the folder");
}

TEST_F(Bench, AgainstAnEarlierVersionShowsItsMediansAndTheChange) {
  json earlier = measured();
  earlier["version"] = "0.0.1-earlier";
  earlier["frame_ms"]["median"] = 1e6;
  earlier["stage_ms"]["track_features"]["median"] = 1e-6;
  earlier["stage_ms"].erase("rectify");
  std::ofstream(file_) << earlier;
  const ProgramResult result = bench({"--against", file_});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, ContainsRegex("\nbefore: .* kinetrace 0\\.0\\.1-earlier\n"));
  EXPECT_THAT(result.out, ContainsRegex("\nframe( +[0-9.]+)+ 1000000\\.000  -100\\.0 %\n"));
  EXPECT_THAT(result.out, ContainsRegex("\ntrack_features( +[0-9.]+)+ +0\\.000 +\\+[0-9.]+ %\n"));
  EXPECT_THAT(result.out, ContainsRegex("\nrectify( +[0-9.]+){3}\n")) << "had no such stage";
}

TEST_F(Bench, AgainstWhatIsNoBenchIsRefusedByName) {
  expect_refused(scratch_.file("none.json"), kNoInput, "none.json: no such file");
  expect_refused(scratch_.path().string(), kBadData, scratch_.path().string() + ": is a folder, not a file");
  for (const char* text : {"", "no JSON", "{}", "[]", R"({"version": "1"})", R"({"version": 1})"}) {
    std::ofstream(file_) << text;
    expect_refused(file_, kBadData, file_ + ": is not what `kinetrace bench --out` writes; write it anew");
  }
  std::filesystem::remove(file_);
  json cut = measured();
  cut["stage_ms"]["track_features"].erase("p95");
  std::ofstream(file_) << cut;
  expect_refused(file_, kBadData, file_ + ": is not what `kinetrace bench --out` writes; write it anew");
}

}  // namespace
}  // namespace kinetrace::test
