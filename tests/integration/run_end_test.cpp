// A run writes its results and reports failures to write, however it ends and whichever reader has gone.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <unistd.h>
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

std::string joined(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    line += "'" + word + "' ";
  }
  return line;
}

class RunEnd : public ::testing::Test {
 protected:
  void SetUp() override { recording_.write(); }

  [[nodiscard]] std::vector<std::string> run_arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", "--dataset", recording_.dataset(), "--out", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] nlohmann::json report() const {
    return nlohmann::json::parse(text_of(out_ / "run.json"), nullptr, false);
  }
  void expect_complete() const {
    const nlohmann::json run = report();
    ASSERT_FALSE(run.is_discarded()) << "no run.json";
    const std::string poses = text_of(out_ / "camera.tum");
    EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), run["frames"]);
    EXPECT_GT(run["frames"], 0);
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path out_ = scratch_.path() / "out";
};

class RunEndBySignal : public RunEnd, public ::testing::WithParamInterface<int> {};

TEST_P(RunEndBySignal, EverythingIsWritten) {
  Program program(run_arguments({"--quiet", "--loop", "1000000"}));
  for (int i = 0; i < 600 && text_of(out_ / "camera.tum").empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  program.send(GetParam());
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 128 + GetParam()) << result.err;
  EXPECT_THAT(result.err, HasSubstr("ended early by signal " + std::to_string(GetParam())));
  expect_complete();
}

INSTANTIATE_TEST_SUITE_P(Signals, RunEndBySignal,
                         ::testing::Values(SIGHUP, SIGTERM, SIGALRM, SIGUSR1, SIGUSR2, SIGXCPU));

TEST_F(RunEnd, ACalibrationThatCouldNotBeSavedIsRefusedAtTheStart) {
  for (const std::filesystem::path& place : {scratch_.path() / "none" / "rig.yaml", scratch_.path()}) {
    const ProgramResult result = run_kinetrace(run_arguments({"--save-calibration", place.string()}));
    EXPECT_EQ(result.exit_code, 74);
    EXPECT_THAT(result.err, HasSubstr(place.string() + ": cannot be written"));
    EXPECT_FALSE(std::filesystem::exists(out_)) << "the run began";
  }
}

TEST_F(RunEnd, ACalibrationReplacesAnEarlierCalibrationOnly) {
  std::filesystem::create_directories(out_);
  const std::filesystem::path config = scratch_.path() / "config.yaml";
  std::ofstream(config) << "calibration: {refine: check}\n";
  std::ofstream(scratch_.path() / "kalibr.yaml")
      << "cam0: {intrinsics: [1, 1, 1, 1]}\ncam1: {intrinsics: [1, 1, 1, 1]}\n";
  for (const std::filesystem::path& place :
       {recording_.calibration(), recording_.image(0, 0), config, scratch_.path() / "kalibr.yaml",
        recording_.sequence() / "rig.yaml", out_ / "camera.tum"}) {
    const std::string before = text_of(place);
    const ProgramResult result =
        run_kinetrace(run_arguments({"--config", config.string(), "--save-calibration", place.string()}));
    expect_refusal(result, kCannotCreate, place.string());
    EXPECT_EQ(text_of(place), before);
    EXPECT_TRUE(std::filesystem::is_empty(out_)) << "the run began";
  }
  const std::filesystem::path rig = scratch_.path() / "rig.yaml";
  std::ofstream(rig) << "%YAML:1.0\n---\nK1: [1]\nK2: [1]\nR: [1]\nT: [1]\n";
  EXPECT_EQ(run_kinetrace(run_arguments({"--quiet", "--save-calibration", rig.string()})).exit_code, 0);
}

TEST_F(RunEnd, NohupKeepsARunAlive) {
  const ProgramResult result = run_in_shell("trap '' HUP; $kinetrace " + joined(run_arguments({"--loop", "30"})) +
                                            "& sleep 0.5; kill -HUP $!; wait $!");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_complete();
  EXPECT_EQ(report()["frames"], 30 * recording_.frames);
}

TEST_F(RunEnd, AReaderThatHasGoneDoesNotEndARun) {
  // The first warning has no reader.
  const ProgramResult result =
      run_in_shell("set -o pipefail; $kinetrace " + joined(run_arguments({"--fault", "unplug@2:1", "--loop", "3"})) +
                   " 2>&1 | true");
  EXPECT_EQ(result.exit_code, kIo) << "the summary was not read";
  expect_complete();
}

TEST_F(RunEnd, AStackThatIsTooSmallIsAnErrorThatNamesTheLimit) {
#ifdef KINETRACE_SANITIZED
  GTEST_SKIP() << "sanitizers need more than any limit here";
#endif
  const ProgramResult result = run_in_shell("ulimit -s 128; $kinetrace " + joined(run_arguments({})));
  expect_refusal(result, kIo, "the stack is limited to 128 KiB, and 256 are needed; raise the limit (ulimit -s)");
  EXPECT_EQ(run_in_shell("ulimit -s 256; $kinetrace " + joined(run_arguments({"--quiet"}))).exit_code, 0);
}

TEST_F(RunEnd, AFileSizeLimitIsAnErrorThatNamesTheFile) {
  const ProgramResult result = run_in_shell("ulimit -f 100; $kinetrace " + joined(run_arguments({"--loop", "50"})));
  EXPECT_EQ(result.exit_code, kIo) << result.err;
  EXPECT_THAT(result.err, HasSubstr(out_.string()));
}

TEST_F(RunEnd, AFullStandardOutputIsAnError) {
  ASSERT_EQ(run_in_shell("$kinetrace " + joined(run_arguments({"--quiet"}))).exit_code, 0);
  const std::string folder = std::string("'").append(out_.string()).append("'");
  for (const std::string& command :
       {std::string("config"), std::string("plan"), std::string("reference bash"), std::string("--help"),
        "summary " + folder, "summary --json " + folder, joined(run_arguments({"--json"})), joined(run_arguments())}) {
    const ProgramResult result = run_in_shell("$kinetrace " + command + " > /dev/full");
    EXPECT_EQ(result.exit_code, kIo) << command;
    EXPECT_THAT(result.err, HasSubstr("error: standard output: cannot be written")) << command;
  }
  expect_complete();
  // A quiet run loses no output.
  EXPECT_EQ(run_in_shell("$kinetrace " + joined(run_arguments({"--quiet"})) + " > /dev/full").exit_code, 0);
}

TEST_F(RunEnd, AClosedStandardOutputIsNotAFileOfTheRun) {
  const ProgramResult result = run_in_shell("$kinetrace " + joined(run_arguments()) + " >&- 2>&- <&-");
  EXPECT_EQ(result.exit_code, kIo);
  expect_complete();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out_)) {
    if (entry.is_regular_file()) {
      EXPECT_THAT(text_of(entry.path()), ::testing::Not(HasSubstr("Results in"))) << entry.path();
    }
  }
}

}  // namespace
}  // namespace kinetrace::test
