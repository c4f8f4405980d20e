// The built program on two live cameras, as a user calls it. Objects are found by motion alone: emulated, a neural
// network takes seconds.
#include "program.hpp"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "temp_folder.hpp"
#include "vivid.hpp"

namespace kinetrace::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LiveProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    constexpr int kColourSquares = 4;
    for (const hal::test::VividControls* view : {&left_, &right_}) {
      view->set("Test Pattern", kColourSquares);
    }
    std::ofstream(file("rig.yaml")) << "cam0:\n"
                                    << lens() << "cam1:\n"
                                    << "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n"
                                       "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
                                    << lens();
    std::ofstream(camera_) << "source: v4l2\ncalibration: rig.yaml\ndevices:\n  left: " << hal::test::kVividLeft
                           << "\n  right: " << hal::test::kVividRight
                           << "\nimage:\n  format: grey8\n  width_px: 320\n  height_px: 180\n  rate_hz: 5\n"
                              "pairing:\n  tolerance_ms: 100\ntimeouts:\n  stall_ms: 4000\n  lost_ms: 4000\n";
  }
  [[nodiscard]] static std::string lens() {
    return "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [250.0, 250.0, 160.0, 90.0]\n"
           "  resolution: [320, 180]\n";
  }
  [[nodiscard]] std::string file(const std::string& name) const { return scratch_.file(name); }

  hal::test::VividControls left_{hal::test::kVividLeft};
  hal::test::VividControls right_{hal::test::kVividRight};
  TempFolder scratch_;
  std::string camera_ = file("camera.yaml");
};

TEST_F(LiveProgram, DoctorListsTheDevicesAndTriesThem) {
  const ProgramResult result =
      run_kinetrace({"doctor", camera_, "--set", "segmentation.mode=motion", "--seconds", "3"});
  EXPECT_THAT(result.out,
              AllOf(HasSubstr(hal::test::kVividLeft), HasSubstr(hal::test::kVividRight), HasSubstr("grey8 320x180")));
  for (const char* good : {"ok    rig", "ok    memory", "ok    camera", "ok    rate"}) {
    EXPECT_THAT(result.out, HasSubstr(good));
  }
  // The kernel decides the skew of the two cameras: the program reports it and ends accordingly.
  EXPECT_THAT(result.out, HasSubstr("skew"));
  EXPECT_EQ(result.exit_code, result.out.find("FAIL") == std::string::npos ? 0 : 1) << result.out << result.err;
}

// Both cameras show the same test picture, which would end a run.
constexpr const char* kContinue = "input.unusable=warn";

// The virtual machine is slow: frames may be left out, but all are accounted for.
TEST_F(LiveProgram, RunIsLiveAndSaysThatTheCameraStreamed) {
  const ProgramResult result = run_kinetrace({"run", "--camera", camera_, "--segmentation", "motion", "--frames", "5",
                                              "--out", file("run"), "--quiet", "--set", kContinue});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  std::ifstream file_of_run(file("run/run.json"));
  const nlohmann::json report = nlohmann::json::parse(file_of_run, nullptr, false);
  const nlohmann::json& live = report["live"];
  EXPECT_EQ(report["frames"].get<int>() + live["frames_left_out"].get<int>(), 5);
  EXPECT_EQ(live["latency_ms"]["count"], report["frames"]);
  EXPECT_GT(live["latency_ms"]["p50"], 0.0) << "exposure is before the result";
  EXPECT_LT(live["latency_ms"]["max"], 60'000.0) << "both are measured by one clock";
  EXPECT_EQ(report["health"]["camera"], "streaming");
  EXPECT_EQ(report["counters"]["camera_losses"], 0);
}

// While the program is stopped the driver fills its buffers, whose images are old afterwards.
TEST_F(LiveProgram, BeingHeldUpIsNoJumpOfTheClock) {
  constexpr auto kLong = std::chrono::seconds(4);
  Program program({"run", "--camera", camera_, "--segmentation", "motion", "--seconds", "8", "--out", file("run"),
                   "--quiet", "--set", kContinue});
  for (int i = 0; i < 100 && !std::filesystem::exists(file("run/camera.tum")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  program.send(SIGSTOP);
  std::this_thread::sleep_for(kLong);
  program.send(SIGCONT);
  const ProgramResult result = program.wait();
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  std::ifstream file_of_run(file("run/run.json"));
  const nlohmann::json report = nlohmann::json::parse(file_of_run, nullptr, false);
  EXPECT_EQ(report["counters"]["camera_clock_jumps"], 0);
  EXPECT_EQ(report["counters"]["camera_losses"], 0);
  EXPECT_GT(report["counters"]["frames_missing_in_numbering"], 0) << "the driver had no room for all";
}

TEST_F(LiveProgram, WhatIsRecordedCanBePlayed) {
  const ProgramResult recorded =
      run_kinetrace({"record", "--camera", camera_, "--frames", "4", "--out", file("raw"), "--quiet"});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.out << recorded.err;
  const ProgramResult played = run_kinetrace({"run", "--dataset", "kitti-raw:" + file("raw"), "--segmentation",
                                              "motion", "--out", file("run"), "--quiet", "--set", kContinue});
  ASSERT_EQ(played.exit_code, 0) << played.out << played.err;
  std::ifstream file_of_run(file("run/run.json"));
  EXPECT_EQ(nlohmann::json::parse(file_of_run, nullptr, false)["frames"], 4);
}

TEST_F(LiveProgram, ACameraThatIsNotThereIsNamed) {
  const std::string other = file("other.yaml");
  std::ifstream from(camera_);
  std::string text(std::istreambuf_iterator<char>(from), {});
  text.replace(text.find(hal::test::kVividRight), hal::test::kVividRight.size(), "usb-nowhere-1");
  std::ofstream(other) << text;
  const ProgramResult result =
      run_kinetrace({"run", "--camera", other, "--segmentation", "motion", "--out", file("none"), "--quiet"});
  EXPECT_EQ(result.exit_code, 66) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("usb-nowhere-1"), HasSubstr(hal::test::kVividLeft)));
}

}  // namespace
}  // namespace kinetrace::test
