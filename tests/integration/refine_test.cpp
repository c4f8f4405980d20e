// `kinetrace refine` and `run --refine batch` from outside, on a small recording.
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class Refine : public ::testing::Test {
 protected:
  void SetUp() override {
    recording_.root = folder_.path() / "recording";
    recording_.frames = 12;
    recording_.write();
  }
  [[nodiscard]] ProgramResult run(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", "--dataset", recording_.dataset(), "--segmentation", "motion", "--quiet", "--out",
                               path("run")});
    return run_kinetrace(more);
  }
  [[nodiscard]] ProgramResult refine() const {
    return run_kinetrace({"refine", path("run"), "--out", path("refined")});
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  TempFolder folder_;
  SmallRecording recording_;
};

TEST_F(Refine, WritesARunFolderThatOtherCommandsTake) {
  ASSERT_EQ(run().exit_code, 0);
  const ProgramResult result = refine();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Refined 12 frames"));
  const Json json = Json::parse(text_of(path("refined/run.json")));
  EXPECT_EQ(json.at("frames"), 12);
  EXPECT_EQ(json.at("dataset").at("refined_from"), path("run"));
  EXPECT_EQ(run_kinetrace({"summary", path("refined")}).exit_code, 0);
  EXPECT_EQ(run_kinetrace({"figure", path("refined"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(run_kinetrace({"refine", path("refined"), "--out", path("again")}).exit_code, 0);
}

TEST_F(Refine, KeepsTheRunThatItRefines) {
  ASSERT_EQ(run().exit_code, 0);
  expect_refusal(run_kinetrace({"refine", path("run"), "--out", path("run")}), kUsage, "is the run itself");
  expect_refusal(run_kinetrace({"refine", path("run"), "--out", path("nested/../run")}), kUsage, "is the run itself");
  EXPECT_TRUE(fs::exists(path("run/run.json")));
}

TEST_F(Refine, NeedsWhatTheRunSaw) {
  ASSERT_EQ(run({"--set", "output.observations=false"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(path("run/observations.bin")));
  expect_refusal(refine(), kNoInput, "output.observations");
}

TEST_F(Refine, RefusesDamagedObservations) {
  ASSERT_EQ(run().exit_code, 0);
  truncate_file(path("run/observations.bin"), fs::file_size(path("run/observations.bin")) - 10);
  expect_refusal(refine(), kBadData, "observations.bin");
}

TEST_F(Refine, TakesWhatARunHasLeftThatWasKilled) {
  ASSERT_EQ(run().exit_code, 0);
  fs::create_directories(path("run/.spool"));
  fs::rename(path("run/run.json"), path("run/.spool/run.json"));
  truncate_file(path("run/observations.bin"), fs::file_size(path("run/observations.bin")) / 2 + 5);
  const ProgramResult result = refine();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("did not end in good order"));
}

TEST_F(Refine, FollowsARunThatAsksForIt) {
  const ProgramResult result = run({"--refine", "batch"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json refined = Json::parse(text_of(path("run/run.json")));
  EXPECT_EQ(refined.at("dataset").at("refined_from"), path("run.online"));
  const Json online = Json::parse(text_of(path("run.online/run.json")));
  EXPECT_EQ(online.at("config").at("features").at("max_features"), 4000);
}

}  // namespace
}  // namespace kinetrace::test
