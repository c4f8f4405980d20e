// The program as a user and a script meet it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class CommandLine : public ::testing::Test {
 protected:
  std::vector<std::string> run_arguments(const std::filesystem::path& out, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", "--dataset", recording_.dataset(), "--out", out.string()});
    return more;
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path out_ = scratch_.path() / "out";
};

TEST_F(CommandLine, HelpListsCommandsAndExitCodes) {
  const ProgramResult result = run_kinetrace({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out,
              ::testing::AllOf(HasSubstr("run"), HasSubstr("plan"), HasSubstr("config"), HasSubstr("record"),
                               HasSubstr("doctor"),
                               HasSubstr("Exit codes: 0 done, 1 a condition of --fail-if holds or a check")));
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(run_kinetrace({"run", "--help"}).out, HasSubstr("--dataset LAYOUT:PATH"));
}

TEST_F(CommandLine, VersionIsOneLine) {
  const ProgramResult result = run_kinetrace({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "kinetrace " KINETRACE_VERSION "\n");
}

TEST_F(CommandLine, WrongUseIsExitCode64AndPointsToTheHelp) {
  const std::vector<std::vector<std::string>> wrong{{},
                                                    {"fly"},
                                                    {"run"},
                                                    {"run", "--out", "x"},
                                                    run_arguments("x", {"--frames", "0"}),
                                                    run_arguments("x", {"--cameras", "infrared"}),
                                                    {"plan", "--size", "12"},
                                                    {"plan", "--size", "0x0"}};
  for (const auto& arguments : wrong) {
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, 64) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
  for (const std::string dataset : {"kitti-odometry", "kitti-odometry:", "super8:/tmp"}) {
    const ProgramResult result = run_kinetrace({"run", "--dataset", dataset, "--out", "x"});
    EXPECT_EQ(result.exit_code, 64) << result.err;
    EXPECT_THAT(result.err, HasSubstr(dataset.substr(0, dataset.find(':'))));
  }
  EXPECT_FALSE(std::filesystem::exists("x"));
}

TEST_F(CommandLine, DefaultConfigurationFileIsWhatTheProgramPrints) {
  const ProgramResult result = run_kinetrace({"config"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, text_of(std::filesystem::path(KINETRACE_SOURCE_DIR) / "config" / "default.yaml"))
      << "renew it with: kinetrace config > config/default.yaml";
}

TEST_F(CommandLine, EveryConfigurationFileIsAccepted) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(KINETRACE_SOURCE_DIR) / "config")) {
    if (entry.path().extension() == ".yaml") {
      // The table of sizes is no configuration, but named by one.
      const ProgramResult result = entry.path().filename() == "sizes.yaml"
                                       ? run_kinetrace({"config", "--set", "trajectory.sizes=" + entry.path().string()})
                                       : run_kinetrace({"config", "--config", entry.path().string()});
      EXPECT_EQ(result.exit_code, 0) << entry.path() << result.err;
      ++files;
    }
  }
  EXPECT_GT(files, 0);
}

TEST_F(CommandLine, SettingsWinOverTheFileAndTheFileOverDefaults) {
  const std::filesystem::path file = scratch_.path() / "mine.yaml";
  std::ofstream(file) << "memory: {budget_mib: 100, libraries_mib: 30}\n";
  const ProgramResult result = run_kinetrace({"config", "--config", file.string(), "--set", "memory.budget_mib=200"});
  EXPECT_THAT(result.out, HasSubstr("  budget_mib: 200\n"));
  EXPECT_THAT(result.out, HasSubstr("  libraries_mib: 30\n"));
}

TEST_F(CommandLine, PathsOfAConfigurationFileAreRelativeToItAndThoseOfASettingToTheWorkingFolder) {
  const std::filesystem::path sizes = std::filesystem::path(KINETRACE_SOURCE_DIR) / "config" / "sizes.yaml";
  const std::filesystem::path folder = std::filesystem::canonical(scratch_.path());
  std::filesystem::create_directory(folder / "rig");
  std::filesystem::copy_file(sizes, folder / "rig" / "sizes.yaml");
  const std::string file = (folder / "rig" / "mine.yaml").string();
  std::ofstream(file) << "trajectory: {sizes: sizes.yaml}\nsegmentation: {left_dir: /masks}\n";
  const ProgramResult beside = run_kinetrace({"config", "--config", file});
  EXPECT_THAT(beside.out, HasSubstr("  sizes: \"" + (folder / "rig" / "sizes.yaml").string() + "\"\n")) << beside.err;
  EXPECT_THAT(beside.out, HasSubstr("  left_dir: \"/masks\"\n"));
  EXPECT_THAT(beside.out, HasSubstr("  right_dir: \"\"\n"));
  // What is printed holds in every folder.
  const ProgramResult set = run_in_shell("cd '" + folder.string() + "' && $kinetrace config --set " +
                                         "trajectory.sizes=rig/sizes.yaml > printed.yaml && cd / && $kinetrace plan "
                                         "--config '" +
                                         (folder / "printed.yaml").string() + "'");
  EXPECT_EQ(set.exit_code, 0) << set.err;
  std::filesystem::remove(folder / "rig" / "sizes.yaml");
  expect_refusal(run_kinetrace({"plan", "--config", file}), kNoInput, (folder / "rig" / "sizes.yaml").string());
}

TEST_F(CommandLine, PlanListsThePartsAndRefusesASmallBudget) {
  const ProgramResult plan = run_kinetrace({"plan", "--size", "640x480"});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  for (const char* part : {"camera", "rectifier", "recorder", "libraries", "total", "memory.budget_mib"}) {
    EXPECT_THAT(plan.out, HasSubstr(part));
  }
  const ProgramResult refused = run_kinetrace({"plan", "--set", "memory.budget_mib=23"});
  EXPECT_EQ(refused.exit_code, 78);
  EXPECT_THAT(refused.err, HasSubstr("too small"));
}

TEST_F(CommandLine, WithoutABudgetAPlanIsAsLargeAsItNeedsToBe) {
  const ProgramResult large = run_kinetrace({"plan", "--size", "1920x1080"});
  EXPECT_EQ(large.exit_code, 0) << large.err;
  EXPECT_THAT(large.out, HasSubstr("memory.budget_mib is 0: what the plan needs"));
  // A board's budget and an explicit one are enforced.
  for (const std::vector<std::string>& given :
       {std::vector<std::string>{"--board", "wearable-512"}, {"--set", "memory.budget_mib=64"}}) {
    std::vector<std::string> plan{"plan", "--size", "1920x1080"};
    plan.insert(plan.end(), given.begin(), given.end());
    EXPECT_EQ(run_kinetrace(plan).exit_code, 78);
  }
}

TEST_F(CommandLine, CameraFollowsTheSceneInMetres) {
  recording_.frames = 12;
  recording_.write();
  const ProgramResult result = run_kinetrace(run_arguments(out_));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Results in " + out_.string()));
  // The default network was not chosen by the user, so its limits are a note and no warning.
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out, HasSubstr("Note: "));
  EXPECT_THAT(result.out, HasSubstr("was trained on rendered pictures alone"));
  std::ifstream poses(out_ / "camera.tum");
  int frame = 0;
  for (std::string line; std::getline(poses, line); ++frame) {
    double t = 0.0, x = 0.0, y = 0.0, z = 0.0;
    std::istringstream(line) >> t >> x >> y >> z;
    EXPECT_NEAR(t, 0.1 * frame, 1e-9);
    EXPECT_NEAR(x, frame * SmallRecording::kStep, 0.02) << "frame " << frame;
    EXPECT_NEAR(y, 0.0, 0.02);
    EXPECT_NEAR(z, 0.0, 0.04);
  }
  EXPECT_EQ(frame, recording_.frames);
}

TEST_F(CommandLine, JsonIsTheOnlyOutputAndComplete) {
  recording_.write();
  const ProgramResult result = run_kinetrace(run_arguments(out_, {"--json", "--frames", "4"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json run = nlohmann::json::parse(result.out, nullptr, false);
  ASSERT_FALSE(run.is_discarded()) << result.out;
  EXPECT_EQ(result.out, text_of(out_ / "run.json"));
  EXPECT_EQ(run["frames"], 4);
  EXPECT_EQ(run["version"], KINETRACE_VERSION);
  EXPECT_GT(run["rss_peak_bytes"], 1 << 20);
  for (const char* figure : {"median", "p95", "max"}) {
    EXPECT_GT(run["frame_ms"][figure], 0.0);
    EXPECT_GT(run["stage_ms"]["pyramid"][figure], 0.0);
  }
  EXPECT_LE(run["stage_ms"]["pyramid"]["median"], run["frame_ms"]["median"]);
  EXPECT_EQ(run["config"]["memory"]["budget_mib"], 0.0);
  EXPECT_GT(run["planned_bytes"], 1 << 20);
  EXPECT_EQ(run["budget_bytes"], run["planned_bytes"]);
}

TEST_F(CommandLine, NothingOfOursAllocatesAfterStart) {
  recording_.write();
  ASSERT_EQ(run_kinetrace(run_arguments(out_, {"--loop", "5"})).exit_code, 0);
  const nlohmann::json run = nlohmann::json::parse(text_of(out_ / "run.json"));
  EXPECT_EQ(run["frames"], 5 * recording_.frames);
  if (!run.contains("allocations_after_start") || run["allocations_after_start"].is_null()) {
    GTEST_SKIP() << "this build does not count allocations";
  }
  EXPECT_EQ(run["allocations_after_start"], 0) << run.dump(2);
}

TEST_F(CommandLine, SameInputGivesTheSameOutput) {
  recording_.write();
  const std::filesystem::path again = scratch_.path() / "again";
  ASSERT_EQ(run_kinetrace(run_arguments(out_, {"--segmentation", "motion"})).exit_code, 0);
  ASSERT_EQ(run_kinetrace(run_arguments(again, {"--segmentation", "motion"})).exit_code, 0);
  for (const char* file : {"camera.tum", "camera_kitti.txt", "objects.csv", "points/background.ply"}) {
    EXPECT_EQ(text_of(out_ / file), text_of(again / file)) << file;
    EXPECT_NE(text_of(out_ / file), "") << file;
  }
}

TEST_F(CommandLine, HoweverManyThreadsShareTheWorkTheOutputIsTheSame) {
  recording_.write();
  for (const char* threads : {"1", "2", "4"}) {
    const std::string setting = std::string("processing.threads=") + threads;
    const std::filesystem::path out = scratch_.path() / threads;
    ASSERT_EQ(run_kinetrace(run_arguments(out, {"--segmentation", "motion", "--set", setting})).exit_code, 0);
    for (const char* file : {"camera.tum", "objects.csv", "points/background.ply"}) {
      EXPECT_EQ(text_of(out / file), text_of(scratch_.path() / "1" / file)) << file << " of " << threads;
    }
  }
  const ProgramResult none = run_kinetrace(run_arguments(out_, {"--set", "processing.threads=0"}));
  EXPECT_EQ(none.exit_code, 78);
  EXPECT_THAT(none.err, HasSubstr("processing.threads"));
}

TEST_F(CommandLine, AnEarlierRunIsReplaced) {
  recording_.write();
  ASSERT_EQ(run_kinetrace(run_arguments(out_)).exit_code, 0);
  ASSERT_EQ(run_kinetrace(run_arguments(out_, {"--frames", "2"})).exit_code, 0);
  const std::string poses = text_of(out_ / "camera.tum");
  EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), 2);
}

TEST_F(CommandLine, QuietSaysNothing) {
  recording_.write();
  const ProgramResult result = run_kinetrace(run_arguments(out_, {"--quiet"}));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out + result.err, IsEmpty());
}

TEST_F(CommandLine, SignalEndsARunWithEverythingWritten) {
  recording_.write();
  Program program(run_arguments(out_, {"--loop", "1000000"}));
  // Started once poses are being written.
  for (int i = 0; i < 600 && !std::filesystem::exists(out_ / "camera.tum"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 128 + SIGINT) << result.err;
  const nlohmann::json run = nlohmann::json::parse(text_of(out_ / "run.json"), nullptr, false);
  ASSERT_FALSE(run.is_discarded());
  const std::string poses = text_of(out_ / "camera.tum");
  EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), run["frames"]);
  EXPECT_GT(run["frames"], 0);
}

}  // namespace
}  // namespace kinetrace::test
