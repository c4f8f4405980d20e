// run --camera, record and doctor from outside, on a file camera.
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

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Waits until the file has content; false after a generous time-out.
bool grows(const std::filesystem::path& path) {
  constexpr auto kFarTooLong = std::chrono::minutes(2);
  const auto end = std::chrono::steady_clock::now() + kFarTooLong;
  while (std::chrono::steady_clock::now() < end) {
    std::error_code absent;
    if (std::filesystem::file_size(path, absent) > 0 && !absent) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

class CameraCommand : public ::testing::Test {
 protected:
  /// A camera file that plays the small recording; `more` is added to it.
  std::string camera(const std::string& more = "", int loop = 1) {
    recording_.write();
    // The path is relative to the file.
    return written("source: files\nfiles:\n  layout: kitti-odometry\n  path: recording/sequences/00\n  loop: " +
                   std::to_string(loop) + "\n" + more);
  }
  std::string written(const std::string& text) {
    const std::filesystem::path path = scratch_.path() / "camera.yaml";
    std::ofstream(path) << text;
    return path.string();
  }
  ProgramResult run(const std::string& camera, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", "--camera", camera, "--out", out_.string(), "--quiet"});
    return run_kinetrace(more);
  }
  nlohmann::json report() { return nlohmann::json::parse(text_of(out_ / "run.json"), nullptr, false); }
  std::string raw() { return (scratch_.path() / "raw").string(); }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path out_ = scratch_.path() / "out";
};

TEST_F(CameraCommand, AFileCameraRunsLikeItsRecording) {
  ASSERT_EQ(run(camera()).exit_code, 0);
  const std::string as_camera = text_of(out_ / "camera.tum");
  EXPECT_EQ(report()["health"]["worst"], "ok");
  ASSERT_EQ(run_kinetrace({"run", "--dataset", recording_.dataset(), "--out", out_.string(), "--quiet"}).exit_code, 0);
  EXPECT_EQ(as_camera, text_of(out_ / "camera.tum"));
  EXPECT_NE(as_camera, "");
}

TEST_F(CameraCommand, StopsAfterFramesOrSecondsOrASignal) {
  const std::string endless = camera("", 1'000'000);
  ASSERT_EQ(run(endless, {"--frames", "7"}).exit_code, 0);
  EXPECT_EQ(report()["frames"], 7);
  ASSERT_EQ(run(endless, {"--seconds", "0.3"}).exit_code, 0);
  EXPECT_GT(report()["frames"], 0);
  const std::filesystem::path endless_out = scratch_.path() / "endless";
  Program program({"run", "--camera", endless, "--out", endless_out.string(), "--quiet"});
  // The first poses show that it runs; before, no signal handler is installed.
  EXPECT_TRUE(grows(endless_out / "camera.tum"));
  program.send(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 128 + SIGINT);
}

TEST_F(CameraCommand, FaultsMayStandInTheCameraFile) {
  const std::string faulty = camera("faults: \"unplug@2,drop@4\"\n");
  const ProgramResult result = run(faulty);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(report()["frames"], recording_.frames - 2);
  EXPECT_EQ(report()["dataset"]["faults"], "unplug@2,drop@4");
  EXPECT_EQ(report()["health"]["worst"], "lost");
  EXPECT_EQ(report()["health"]["camera"], "streaming");
}

TEST_F(CameraCommand, ACameraThatNeverDeliversIsAnError) {
  const ProgramResult result = run(camera(), {"--fault", "stuck@0-5"});
  EXPECT_EQ(result.exit_code, 74) << result.err;
  const ProgramResult silent = run(camera("", 1000), {"--fault", "stuck@0-9999999", "--seconds", "0.3"});
  EXPECT_EQ(silent.exit_code, 74) << silent.err;
  EXPECT_THAT(silent.err, HasSubstr("kinetrace doctor"));
  EXPECT_EQ(report()["health"]["state"], "degraded");
}

TEST_F(CameraCommand, RecordsWhatItProcesses) {
  const std::string source = camera("", 20);
  ASSERT_EQ(run(source, {"--record", raw()}).exit_code, 0);
  EXPECT_EQ(report()["counters"]["raw_frames_recorded"], 20 * recording_.frames) << "a recording waits for the disk";
  EXPECT_EQ(report()["counters"]["raw_frames_dropped"], 0);
  EXPECT_EQ(report()["allocations_after_start"].is_null() ? 0 : report()["allocations_after_start"].get<int>(), 0);
}

TEST_F(CameraCommand, ResultsAndRecordingDoNotShareAFolder) {
  const std::string source = camera();
  ASSERT_EQ(run(source).exit_code, 0);
  const std::string out = scratch_.file("out");
  const std::string kept = text_of(out + "/run.json");
  expect_refusal(run(source, {"--record", out + "/"}), kUsage,
                 "--record " + out + "/: is the folder of the results, " + out +
                     "; results and recording cannot share a folder, name another one");
  expect_refusal(run(source, {"--record", scratch_.path().string()}), kUsage, "holds the folder of the results");
  expect_refusal(run(source, {"--refine", "batch", "--record", out + ".online"}), kUsage, out + ".online");
  // A place that is refused later must not have cost the earlier run.
  std::ofstream(scratch_.file("file")) << "text";
  expect_refusal(run(source, {"--record", scratch_.file("file") + "/raw"}), kCannotCreate, "file/raw: cannot be made");
  std::filesystem::create_directories(raw() + "/earlier");
  expect_refusal(run(source, {"--record", raw()}), kCannotCreate,
                 raw() + ": is not empty; recordings are never written");
  // A recording within the one that is played would become a part of it.
  const std::string within = recording_.sequence().string() + "/raw";
  expect_refusal(run(source, {"--record", within}), kCannotCreate, within + ": lies in the recording ");
  expect_refusal(run_kinetrace({"record", "--dataset", recording_.dataset(), "--out", within}), kCannotCreate,
                 within + ": lies in the recording " + recording_.sequence().string() + "; name another folder");
  EXPECT_FALSE(std::filesystem::exists(within));
  EXPECT_EQ(text_of(out + "/run.json"), kept);
  EXPECT_EQ(run(source, {"--record", out + "/raw"}).exit_code, 0);
}

TEST_F(CameraCommand, ARecordingThatCannotContinueDoesNotStopTheRun) {
  const ProgramResult result = run(camera("", 3), {"--record", raw(), "--keep-free-mib", "1000000000"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, AllOf(HasSubstr("raw recording stopped"), HasSubstr("full")));
  EXPECT_EQ(result.err.find("raw recording stopped"), result.err.rfind("raw recording stopped")) << "once is enough";
  EXPECT_THAT(report()["warnings"].dump(), HasSubstr("raw recording stopped"));
  EXPECT_EQ(report()["frames"], 3 * recording_.frames);
  EXPECT_EQ(report()["health"]["worst"], "degraded");
}

TEST_F(CameraCommand, WhatWasRecordedRunsToTheSameResult) {
  const std::string source = camera();
  ASSERT_EQ(run(source).exit_code, 0);
  const std::string direct = text_of(out_ / "camera.tum");
  const ProgramResult recorded = run_kinetrace({"record", "--camera", source, "--out", raw(), "--container"});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_THAT(recorded.out, HasSubstr(std::to_string(recording_.frames) + " frames"));
  ASSERT_EQ(run_kinetrace({"run", "--dataset", "container:" + raw(), "--out", out_.string(), "--quiet"}).exit_code, 0);
  EXPECT_EQ(direct, text_of(out_ / "camera.tum"));

  // KITTI's times are dates; the rest is equal.
  const std::string kitti = (scratch_.path() / "kitti").string();
  ASSERT_EQ(run_kinetrace({"record", "--camera", source, "--out", kitti, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_kinetrace({"run", "--dataset", "kitti-raw:" + kitti, "--out", out_.string(), "--quiet"}).exit_code, 0);
  const auto without_times = [](const std::string& text) {
    std::istringstream lines(text);
    std::string poses;
    for (std::string line; std::getline(lines, line);) {
      poses += line.substr(line.find(' ')) + "\n";
    }
    return poses;
  };
  EXPECT_EQ(without_times(direct), without_times(text_of(out_ / "camera.tum")));
}

TEST_F(CameraCommand, NeverRecordsOverAnything) {
  const std::string source = camera();
  ASSERT_EQ(run_kinetrace({"record", "--camera", source, "--out", raw(), "--container"}).exit_code, 0);
  const ProgramResult again = run_kinetrace({"record", "--camera", source, "--out", raw(), "--container"});
  EXPECT_EQ(again.exit_code, 73) << again.err;
  EXPECT_THAT(again.err, HasSubstr("not empty"));
}

TEST_F(CameraCommand, DoctorFindsAGoodCameraGood) {
  const ProgramResult result = run_kinetrace({"doctor", camera("", 20), "--seconds", "1"});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const char* check : {"device", "rig", "memory", "dds", "camera", "rate", "losses", "calibration", "pairing"}) {
    EXPECT_THAT(result.out, HasSubstr(check));
  }
  EXPECT_THAT(result.out, ::testing::Not(HasSubstr("FAIL")));
}

TEST_F(CameraCommand, DoctorKnowsWhatIsWrongWithTheNetwork) {
  const std::string settings = scratch_.file("dds.yaml");
  std::ofstream(settings) << "dds:\n  interface: kt-none0\n";
  const ProgramResult missing = run_kinetrace({"doctor", "--publish", settings});
  EXPECT_EQ(missing.exit_code, 1) << missing.err;
  EXPECT_THAT(missing.out, HasSubstr("FAIL  dds"));
  std::ofstream(settings) << "dds:\n  interfaces: lo\n";
  const ProgramResult typo = run_kinetrace({"doctor", "--publish", settings});
  EXPECT_EQ(typo.exit_code, 1) << typo.err;
  EXPECT_THAT(typo.out, HasSubstr("FAIL  dds"));
}

TEST_F(CameraCommand, DoctorNamesEachFailureWithItsRemedy) {
  const auto doctor = [](const std::string& file) { return run_kinetrace({"doctor", file, "--seconds", "1"}); };
  const ProgramResult lossy = doctor(camera("faults: \"drop@0-9999%30\"\n", 20));
  EXPECT_EQ(lossy.exit_code, 1);
  EXPECT_THAT(lossy.out, HasSubstr("FAIL  rate"));
  const ProgramResult jumps = doctor(camera("faults: \"clock@5:3600\"\n", 20));
  EXPECT_EQ(jumps.exit_code, 1);
  EXPECT_THAT(jumps.out, HasSubstr("FAIL  rate")) << "times are seen as they come";
  const ProgramResult back = doctor(camera("faults: \"clock@5:-3600\"\n", 20));
  EXPECT_EQ(back.exit_code, 1);
  EXPECT_THAT(back.out, HasSubstr("FAIL  losses"));
  const ProgramResult gone = doctor(camera("faults: \"unplug@3\"\n"));
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.out, HasSubstr("FAIL  stream"));
  recording_.uniform = true;
  const ProgramResult blank = doctor(camera("", 5));
  EXPECT_EQ(blank.exit_code, 1);
  EXPECT_THAT(blank.out, AllOf(HasSubstr("FAIL  images"), HasSubstr("texture")));
  const ProgramResult missing = doctor((scratch_.path() / "none.yaml").string());
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.out, HasSubstr("none.yaml"));
  const ProgramResult devices = run_kinetrace({"doctor"});
  EXPECT_EQ(devices.exit_code, 0) << "a machine without cameras is not ill";
}

TEST_F(CameraCommand, CameraFilesAreAcceptedOnlyAsAWhole) {
  const auto expect_refused = [this](const std::string& text, int exit_code, const std::string& culprit) {
    const ProgramResult result = run(written(text));
    EXPECT_EQ(result.exit_code, exit_code) << text << result.err;
    EXPECT_THAT(result.err, HasSubstr(culprit)) << text;
  };
  constexpr int kConfig = 78;
  expect_refused("source: telepathy\n", kConfig, "camera.yaml:1");
  expect_refused("source: files\nlens: wide\n", kConfig, "camera.yaml:2");
  expect_refused("source: files\nfiles:\n  path: a\n  path: b\n", kConfig, "camera.yaml:4");
  expect_refused("source: files\n", kConfig, "files.path");
  expect_refused("source: files\nfiles:\n  path: a\n  layout: vhs\n", kConfig, "files.layout");
  expect_refused("source: v4l2\n", kConfig, "calibration");
  expect_refused("calibration: rig.yaml\n", kConfig, "devices.left");
  const std::string left = "calibration: rig.yaml\ndevices:\n  left: /dev/video0\n  right: /dev/video2\n";
  expect_refused(left + "image:\n  rate_hz: .inf\n", kConfig, "camera.yaml:6");
  expect_refused(left + "image:\n  rate_hz: 0\n", kConfig, "image.rate_hz");
  expect_refused(left + "image:\n  exposure_us: 5000\n", kConfig, "image.exposure_us needs image.auto_exposure: false");
  expect_refused(left + "image:\n  gain: 0\n", kConfig, "image.gain needs image.auto_gain: false");
  expect_refused(left + "image:\n  auto_gain: false\n", kConfig, "image.gain is missing");
  expect_refused(left + "image:\n  auto_exposure: false\n", kConfig, "image.exposure_us is missing");
  expect_refused(left + "image:\n  format: sepia\n", kConfig, "camera.yaml:6");
  expect_refused(left + "pairing:\n  tolerance_ms: 17\n", kConfig, "pairing.tolerance_ms");
  expect_refused(left + "faults: \"drop\"\n", kConfig, "KIND@FIRST");
  expect_refused(left, 66, "rig.yaml");
  expect_refused("source: files\nfiles:\n  path: nowhere\n", 66, "nowhere");
  EXPECT_EQ(run((scratch_.path() / "none.yaml").string()).exit_code, 66);
}

TEST_F(CameraCommand, OneSourceIsNeededAndOnlyOne) {
  EXPECT_EQ(run_kinetrace({"run", "--out", "x"}).exit_code, 64);
  EXPECT_EQ(run(camera(), {"--dataset", recording_.dataset()}).exit_code, 64);
  EXPECT_EQ(run_kinetrace({"record", "--out", "x"}).exit_code, 64);
  EXPECT_EQ(run_kinetrace({"record", "--camera", "x"}).exit_code, 64);
  EXPECT_EQ(run(camera(), {"--seconds", "-1"}).exit_code, 64);
}

TEST_F(CameraCommand, WhatWouldHaveNoEffectIsRefused) {
  const std::string source = camera();
  for (const auto& [option, value] : {std::pair{"--sequence", "00"},
                                      {"--cameras", "gray"},
                                      {"--loop", "2"},
                                      {"--segment-mib", "1"},
                                      {"--keep-free-mib", "1"}}) {
    const ProgramResult result = run(source, {option, value});
    EXPECT_EQ(result.exit_code, 64) << option;
    EXPECT_THAT(result.err, HasSubstr(option));
  }
  EXPECT_EQ(run(source, {"--container"}).exit_code, 64);
  EXPECT_EQ(run_kinetrace({"record", "--camera", source, "--out", raw(), "--segment-mib", "1"}).exit_code, 64);
}

TEST_F(CameraCommand, ExamplesOfCameraFilesAreValid) {
  for (const auto& entry : std::filesystem::directory_iterator(KINETRACE_SOURCE_DIR "/config/cameras")) {
    if (entry.path().extension() != ".yaml") {
      continue;
    }
    const ProgramResult result = run(entry.path().string());
    // The named devices, calibrations and recordings do not exist; the rest of each file is valid.
    EXPECT_EQ(result.exit_code, 66) << entry.path() << result.err;
    EXPECT_THAT(result.err, ::testing::AnyOf(HasSubstr("calibration/"), HasSubstr("recordings/"))) << entry.path();
  }
}

TEST_F(CameraCommand, TheGuessedRigStandsInForACalibration) {
  std::string text = text_of(KINETRACE_SOURCE_DIR "/config/cameras/v4l2-pair.yaml");
  const std::string named = "calibration/rig.yaml";
  text.replace(text.find(named), named.size(), KINETRACE_SOURCE_DIR "/config/calibration/guessed-rig.yaml");
  const ProgramResult result = run(written(text));
  // The next error is a missing device.
  EXPECT_EQ(result.exit_code, 66) << result.err;
  EXPECT_THAT(result.err, HasSubstr("usb-0000:00:14.0-1"));
}

}  // namespace
}  // namespace kinetrace::test
