// An error names the unknown word and suggests the nearest known one.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "program.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

void expect_refused(const std::vector<std::string>& arguments, int exit_code, const std::string& text) {
  expect_refusal(run_kinetrace(arguments), exit_code, text);
}

std::vector<std::string> run_with(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"run", "--dataset", "folder:nowhere", "--out", "nowhere"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(WrongWords, OptionIsNamedWithTheNearest) {
  expect_refused(run_with({"--segmantation", "motion"}), kUsage,
                 "error: --segmantation: no such option; did you mean --segmentation?");
  expect_refused(run_with({"--segmantation=motion"}), kUsage, "--segmantation: no such option; did you mean");
  expect_refused({"study", "object-size", ".", "--out", "x", "--windws", "3"}, kUsage, "did you mean --windows?");
  // Options of groups are suggested too, even if the option is required and hence missing.
  expect_refused({"run", "--dateset", "folder:x", "--out", "y"}, kUsage,
                 "--dateset: no such option; did you mean --dataset?");
  expect_refused({"run", "--dataset", "folder:x", "--outt", "y"}, kUsage,
                 "--outt: no such option; did you mean --out?");
  expect_refused({"--versoin"}, kUsage, "--versoin: no such option; did you mean --version?");
}

TEST(WrongWords, OptionThatIsNearNoneOfTheCommandIsNamed) {
  expect_refused({"config", "--overlay", "x"}, kUsage,
                 "--overlay: no such option of kinetrace config; see kinetrace config --help");
}

TEST(WrongWords, NumbersBeyondTheirLimitsAreSaidShortly) {
  expect_refused(run_with({"--frames", "0"}), kUsage, "--frames: must be 1 or more, got 0; see");
  expect_refused(run_with({"--frames", "99999999999"}), kUsage,
                 "--frames: must be at most 2147483647, got 99999999999; see");
  expect_refused(run_with({"--frames", "2.5"}), kUsage, "--frames: must be a whole number, got 2.5; see");
  expect_refused(run_with({"--loop", "-1"}), kUsage, "--loop: must be 1 or more, got -1; see");
  expect_refused(run_with({"--seconds", "nan"}), kUsage, "--seconds: must be in [0.001 - 1e+09], got nan");
  expect_refused({"study", "limit", ".", "--out", "x", "--noise", "nan,1"}, kUsage,
                 "--noise: must be in [0.001 - 10], got nan");
  expect_refused({"doctor", "--seconds", "nan"}, kUsage, "--seconds: must be in [0.1 - 3600], got nan");
}

TEST(WrongWords, CommandIsNamedWithTheNearest) {
  expect_refused({"rnu", "--out", "x"}, kUsage, "error: rnu: no such command; did you mean run?");
  expect_refused({"sumary", "x"}, kUsage, "did you mean summary?");
  expect_refused({"study", "limit", "/no/such/recording", "--out", "/no/such/folder"}, kNoInput,
                 "/no/such/recording: no such recording");
  expect_refused({"study", "objectsize", "x"}, kUsage, "objectsize: no such command; did you mean object-size?");
  expect_refused({"levitate"}, kUsage, "levitate: no such command; see kinetrace --help");
  expect_refused({"plan", "street"}, kUsage, "\"street\" is one argument too many; see kinetrace plan --help");
}

TEST(WrongWords, WhatIsMissingIsSaidWithTheCommandsHelp) {
  expect_refused({"run", "--out", "x"}, kUsage, "see kinetrace run --help");
  expect_refused({}, kUsage, "see kinetrace --help");
}

TEST(WrongWords, LayoutBoardSegmentationAndFault) {
  expect_refused({"run", "--dataset", "kiti-raw:x", "--out", "y"}, kUsage, "did you mean kitti-raw?");
  expect_refused({"plan", "--board", "raspbery-pi-5"}, kConfig, "did you mean raspberry-pi-5?");
  expect_refused(run_with({"--segmentation", "moton"}), kUsage, "did you mean motion?");
  expect_refused(run_with({"--segmentation", "mask:left"}), kUsage, "did you mean masks?");
  expect_refused(run_with({"--segmentation", "masks:"}), kUsage, "masks:LEFT_DIR[,RIGHT_DIR], onnx[:MODEL.yaml], dds");
  TempFolder folder;
  const std::string camera = folder.file("camera.yaml");
  std::ofstream(camera) << "source: files\nfiles: {path: x}\nfaults: duplicat@3\n";
  expect_refused({"record", "--camera", camera, "--out", "y"}, kConfig, "did you mean duplicate?");
}

TEST(WrongWords, KeyOfTheConfiguration) {
  expect_refused({"config", "--set", "memory.budgt_mib=3"}, kConfig, "did you mean memory.budget_mib?");
  expect_refused({"config", "--set", "segmentation.mode=moton"}, kConfig, "did you mean motion?");
}

TEST(WrongWords, KeyOfACameraFileIsNotOneOfTheConfiguration) {
  TempFolder folder;
  const std::string camera = folder.file("camera.yaml");
  std::ofstream(camera) << "source: files\nventilation: 7\n";
  expect_refused({"record", "--camera", camera, "--out", "y"}, kConfig,
                 camera + ":2: unknown key \"ventilation\"; the files in config/cameras show the keys");
}

TEST(WrongWords, AnOptionThatIsGivenTwiceIsNamed) {
  expect_refused(run_with({"--frames", "3", "--frames", "4"}), kUsage, "error: --frames is given 2 times; keep one");
  expect_refused(run_with({"--set", "a=1", "--set", "b=2"}), kConfig, "unknown key \"a\"");
}

TEST(WrongWords, AnEmptyValueIsNotAnOptionLeftOut) {
  expect_refused({"config", "--board", ""}, kUsage, "--board: must not be empty");
  expect_refused({"config", "--config", ""}, kUsage, "--config: must not be empty");
  expect_refused(run_with({"--publish", ""}), kUsage, "--publish: must not be empty");
  expect_refused({"summary", ""}, kUsage, "must not be empty");
}

TEST(WrongWords, AnOptionIsNotTheValueOfTheOneBefore) {
  expect_refused({"config", "--config", "--board"}, kUsage, "--config: needs a value, --board is an option");
  expect_refused(run_with({"--save-calibration", "--frames", "3"}), kUsage,
                 "--save-calibration: needs a value, --frames is an option");
  expect_refused({"summary", "--", "--run"}, kUsage, "--run is an option; a file of that name is ./--run");
}

TEST(WrongWords, AFileThatIsNotThereIsReportedByItsKind) {
  expect_refused({"record", "--camera", "nope.yaml", "--out", "y"}, kNoInput,
                 "nope.yaml: no such camera file; give one that says which devices");
  expect_refused({"config", "--config", "nope.yaml"}, kNoInput, "nope.yaml: no such configuration file");
}

TEST(WrongWords, AFileThatCannotBeReachedIsNotSaidToBeMissing) {
  TempFolder folder;
  std::filesystem::create_symlink("loop", folder.path() / "loop");
  const std::string file = folder.path() / "loop" / "a.yaml";
  expect_refused({"config", "--config", file}, kIo, file + ": cannot be reached (Too many levels of symbolic links)");
  expect_refused({"run", "--dataset", "folder:" + file, "--out", "y"}, kIo, file + ": cannot be reached (");
}

TEST(WrongWords, AnEmptyConfigurationIsNoConfiguration) {
  TempFolder folder;
  const std::string file = folder.file("empty.yaml");
  std::ofstream(file).flush();
  expect_refused({"config", "--config", file}, kConfig,
                 file + ": is empty; `kinetrace config` prints one with all keys");
}

}  // namespace
}  // namespace kinetrace::test
