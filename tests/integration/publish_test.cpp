// The program with --publish.
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;

class Publish : public ::testing::Test {
 protected:
  void SetUp() override { recording_.write(); }
  std::string config(const std::string& yaml) const {
    const std::string path = scratch_.file("publish.yaml");
    std::ofstream(path) << "dds:\n  domain: 11\n" << yaml;
    return path;
  }
  [[nodiscard]] ProgramResult run(const std::string& file) const {
    return run_kinetrace(
        {"run", "--dataset", recording_.dataset(), "--out", out_.string(), "--publish", file, "--quiet"});
  }
  [[nodiscard]] nlohmann::json run_json() const { return nlohmann::json::parse(std::ifstream(out_ / "run.json")); }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path out_ = scratch_.path() / "out";
};

TEST_F(Publish, ARunCountsWhatItPublished) {
  const ProgramResult result = run(config(""));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json run = run_json();
  EXPECT_EQ(run["counters"]["dds_frames_offered"], 6);
  EXPECT_EQ(run["counters"]["dds_frames"].get<int>() + run["counters"]["dds_frames_superseded"].get<int>(), 6);
  EXPECT_EQ(run["counters"]["dds_write_errors"], 0);
  EXPECT_EQ(run["config"]["dds"]["interface"], "lo");
  EXPECT_EQ(allocations_after_start(run), 0);
  EXPECT_TRUE(run["stage_ms"].contains("publish"));
}

TEST_F(Publish, WithoutTheInterfaceTheRunContinuesAndHealthReportsIt) {
  const ProgramResult result = run(config("  interface: nothere0\n"));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("DDS waits: interface nothere0 is not there"));
  const nlohmann::json run = run_json();
  EXPECT_EQ(run["health"]["worst"], "degraded");
  EXPECT_THAT(run["health"]["reasons"].dump(), HasSubstr("not_published"));
}

TEST_F(Publish, TooFewOpenFilesAreAnError) {
  const std::string file = config("");
  // With fewer, the program's libraries cannot be loaded.
  for (const int files : {6, 7, 8, 10, 12, 14}) {
    const ProgramResult result =
        run_in_shell("ulimit -n " + std::to_string(files) + "; exec $kinetrace run --quiet --dataset " +
                     recording_.dataset() + " --out " + out_.string() + " --publish " + file);
    EXPECT_THAT(result.exit_code, ::testing::AnyOf(65, 66, 73, 74, 78)) << files << " files";
    EXPECT_THAT(result.err, HasSubstr("error: ")) << files << " files";
  }
}

TEST_F(Publish, WhatCannotBePublishedIsRefusedBeforeAnythingIsMade) {
  const ProgramResult missing = run((scratch_.path() / "nowhere.yaml").string());
  EXPECT_EQ(missing.exit_code, 66);
  const ProgramResult wrong = run(config("  bytes: 3\n"));
  EXPECT_EQ(wrong.exit_code, 78);
  EXPECT_THAT(wrong.err, HasSubstr("unknown key \"dds.bytes\""));
  const ProgramResult insecure = run(config("  security: {mode: required}\n"));
  EXPECT_EQ(insecure.exit_code, 78);
  EXPECT_THAT(insecure.err, HasSubstr("dds.security.identity_ca is missing"));
  const ProgramResult no_files =
      run(config("  security: {mode: required, identity_ca: a, certificate: b, private_key: c, governance: d, "
                 "permissions: e}\n"));
  EXPECT_EQ(no_files.exit_code, 66);
  EXPECT_THAT(no_files.err, HasSubstr("dds.security.identity_ca: "));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(Publish, ThePlanHasALineForItAndOneForTheLibrary) {
  const ProgramResult plan = run_kinetrace({"plan", "--publish", config("")});
  EXPECT_EQ(plan.exit_code, 0);
  EXPECT_THAT(plan.out, HasSubstr("\npublishing "));
  EXPECT_THAT(plan.out, HasSubstr("\nDDS participant "));
}

}  // namespace
}  // namespace kinetrace::test
