// `kinetrace refine` and `run --refine batch` from outside, on a small recording.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <vector>

#include <Eigen/Core>
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

constexpr std::int64_t kReferenceAhead_ns = 1'600'000'000'000'000'000;

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
  [[nodiscard]] ProgramResult refine(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"refine", path("run"), "--out", path("refined")});
    return run_kinetrace(more);
  }
  /// Distance between the first and the last camera position.
  [[nodiscard]] double distance_of_ends_m(const std::string& run) const {
    std::ifstream file(path(run) + "/camera.tum");
    std::vector<Eigen::Vector3d> places;
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      double time = 0.0;
      Eigen::Vector3d place;
      if (fields >> time >> place.x() >> place.y() >> place.z()) {
        places.push_back(place);
      }
    }
    return (places.back() - places.front()).norm();
  }
  /// Writes the camera's path as EuRoC ground truth, z up.
  void write_reference(const std::string& run, const std::string& name) const {
    std::ifstream file(path(run) + "/camera.tum");
    std::ofstream reference(path(name));
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      double time_s = 0.0;
      Eigen::Vector3d place;
      if (fields >> time_s >> place.x() >> place.y() >> place.z()) {
        reference << kReferenceAhead_ns + std::llround(1e9 * time_s) << ',' << place.x() << ',' << place.z() << ','
                  << -place.y() << '\n';
      }
    }
  }
  /// Adds `difference` to a number of 32 bits in every record of the run's observations.bin.
  void change_observations(std::size_t offset_in_record, std::int32_t difference) const {
    constexpr std::size_t kRecord = 24;  // The header is as long.
    std::string bytes = text_of(path("run/observations.bin"));
    for (std::size_t at = kRecord + offset_in_record; at < bytes.size(); at += kRecord) {
      std::int32_t value = 0;
      std::memcpy(&value, bytes.data() + at, sizeof value);
      value += difference;
      std::memcpy(bytes.data() + at, &value, sizeof value);
    }
    std::ofstream(path("run/observations.bin"), std::ios::binary) << bytes;
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

TEST_F(Refine, FindsAnUnusableFolderBeforeTheWork) {
  ASSERT_EQ(run().exit_code, 0);
  fs::create_directories(path("foreign"));
  std::ofstream(path("foreign/notes.txt")) << "kept";
  expect_refusal(run_kinetrace({"refine", path("run"), "--out", path("foreign")}), kCannotCreate, "not an earlier run");
  expect_refusal(run_kinetrace({"refine", path("run"), "--out", path("foreign/notes.txt/run")}), kCannotCreate,
                 "notes.txt");
  expect_refusal(
      run_kinetrace({"run", "--dataset", recording_.dataset(), "--refine", "batch", "--out", path("foreign")}),
      kCannotCreate, "not an earlier run");
  EXPECT_FALSE(fs::exists(path("foreign.online")));
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

TEST_F(Refine, KnowsTheFramesOfARecordingWhoseFirstOnesAreMissing) {
  ASSERT_EQ(run({"--fault", "drop@0-2"}).exit_code, 0);
  EXPECT_THAT(text_of(path("run/camera_frames.csv")), HasSubstr("frame,timestamp_ns\n3,"));
  EXPECT_EQ(refine().exit_code, 0);
  EXPECT_EQ(text_of(path("refined/camera_frames.csv")), text_of(path("run/camera_frames.csv")));
  EXPECT_EQ(fs::file_size(path("refined/observations.bin")), fs::file_size(path("run/observations.bin")));
}

TEST_F(Refine, SaysIfItRefinedNothing) {
  ASSERT_EQ(run().exit_code, 0);
  change_observations(0, 5);  // Track ids: no background is left.
  const ProgramResult result = refine();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("the camera's path was not refined"));
}

TEST_F(Refine, RefusesObservationsOfOtherFrames) {
  ASSERT_EQ(run().exit_code, 0);
  change_observations(8, 7);  // Frame numbers.
  expect_refusal(refine(), kBadData, "is none of the run's");
}

TEST_F(Refine, DoesNotWaitForAPipeInTheRunFolder) {
  ASSERT_EQ(run().exit_code, 0);
  for (const char* name : {"observations.bin", "points/background.ply", "colmap/background/images.txt"}) {
    const std::string file = path("run/") + name;
    fs::rename(file, file + ".kept");
    ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
    expect_refusal(refine(), kBadData, file + ": is a named pipe");
    EXPECT_FALSE(fs::exists(path("refined")));
    fs::remove(file);
    fs::rename(file + ".kept", file);
  }
  fs::remove(path("run/observations.bin"));
  ASSERT_EQ(::mkfifo(path("run/observations.bin").c_str(), 0600), 0);
  EXPECT_EQ(run_kinetrace({"figure", path("run"), "--quiet"}).exit_code, 0);
}

TEST_F(Refine, TakesItsCommandLineAsItIs) {
  const auto refusal = [](std::vector<std::string> arguments, const std::string& culprit) {
    arguments.insert(arguments.begin(), "refine");
    expect_refusal(run_kinetrace(arguments), kNoInput, culprit);
  };
  refusal({"--out", path("refined"), "--", "-z"}, "-z");
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_THAT(refine({"--quiet=false"}).out, HasSubstr("Refined 12 frames"));
  EXPECT_THAT(refine({"--quiet=true"}).out, ::testing::IsEmpty());
  fs::rename(recording_.root, path("moved"));
  EXPECT_THAT(refine({"--no-images=false"}).err, HasSubstr("points were not measured again"));
  EXPECT_THAT(refine({"--no-images"}).err, ::testing::IsEmpty());
}

TEST_F(Refine, PrintsWhatItWrote) {
  ASSERT_EQ(run().exit_code, 0);
  const ProgramResult result = refine({"--json", "--quiet"});
  EXPECT_EQ(result.out, text_of(path("refined/run.json")));
}

TEST_F(Refine, HoldsItsFolderFromTheStart) {
  recording_.frames = 60;
  recording_.write();
  ASSERT_EQ(run().exit_code, 0);
  Program first({"refine", path("run"), "--out", path("refined")});
  for (int i = 0; i < 60'000 && !fs::exists(path("refined")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  expect_refusal(refine(), kCannotCreate, "another run");
  first.send(SIGINT);
  EXPECT_EQ(first.wait().exit_code, 128 + SIGINT);
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

TEST_F(Refine, ClosesLoopsOfACameraThatComesBack) {
  recording_.frames = 80;
  recording_.step_m = 0.5;
  recording_.turns_back = true;
  recording_.write();
  ASSERT_EQ(run().exit_code, 0);
  const ProgramResult result = refine();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Closed "));
  const std::string loops = Json::parse(text_of(path("refined/run.json"))).at("dataset").at("loops");
  EXPECT_GE(std::stoi(loops), 5);
  EXPECT_LT(distance_of_ends_m("refined"), 0.5 * distance_of_ends_m("run"));

  // Without the images there is a result and a note on the missing ones; --dataset gives their new place.
  fs::rename(recording_.root, path("moved"));
  recording_.root = path("moved");
  const ProgramResult blind = refine();
  ASSERT_EQ(blind.exit_code, 0) << blind.err;
  EXPECT_THAT(blind.err, HasSubstr("--dataset LAYOUT:PATH"));
  EXPECT_THAT(refine({"--no-images"}).err, ::testing::IsEmpty());
  const ProgramResult found = refine({"--dataset", recording_.dataset()});
  EXPECT_THAT(found.out, HasSubstr("Closed "));
  EXPECT_THAT(found.err, ::testing::IsEmpty());
  expect_refusal(refine({"--dataset", "kitti-odometry:" + path("nowhere")}), kNoInput, "nowhere");
}

TEST_F(Refine, SaysWhichFramesHaveLostTheirImages) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_THAT(refine().err, ::testing::IsEmpty());
  for (const int frame : {10, 11}) {
    fs::remove(recording_.image(0, frame));
    fs::remove(recording_.image(1, frame));
  }
  const ProgramResult refined = refine();
  EXPECT_EQ(refined.exit_code, 0);
  EXPECT_THAT(refined.err, HasSubstr("the points of 2 frames were not measured again: the recording has no images"));
}

TEST_F(Refine, RefusesAnotherRecording) {
  ASSERT_EQ(run().exit_code, 0);
  SmallRecording other{.root = folder_.path() / "other", .frames = 12, .step_m = 0.2};
  other.write();
  const ProgramResult result = refine({"--dataset", other.dataset()});
  expect_refusal(result, kBadData, other.dataset() + ": is another recording");
  EXPECT_THAT(result.err, HasSubstr(recording_.dataset()));
  EXPECT_FALSE(fs::exists(path("refined")));
}

TEST_F(Refine, HoldsThePathByAReference) {
  recording_.frames = 30;
  recording_.step_m = 0.5;
  recording_.write();
  ASSERT_EQ(run().exit_code, 0);
  write_reference("run", "truth.csv");
  // The path is straight, so the rotation about it is that of a level camera.
  const std::vector<std::string> reference{"--no-loops",
                                           "--reference",
                                           "euroc:" + path("truth.csv"),
                                           "--origin",
                                           "49.011,8.416,116.4",
                                           "--time-offset",
                                           "-1600000000",
                                           "--dof",
                                           "4"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = reference;
    all.insert(all.end(), more.begin(), more.end());
    return refine(all);
  };
  const ProgramResult held = with({"--max-time-offset", "0"});
  ASSERT_EQ(held.exit_code, 0) << held.err;
  EXPECT_THAT(held.out, HasSubstr("Held the path by 30 of 30 fixes"));
  EXPECT_EQ(Json::parse(text_of(path("refined/run.json"))).at("dataset").at("reference"), "euroc:" + path("truth.csv"));
  // The camera drives straight ahead at a constant speed.
  expect_refusal(with({}), kBadData, "the reference does not hold the path: the place along the path");
  expect_refusal(refine({"--reference", "sextant:" + path("truth.csv")}), kUsage, "oxts, nmea, gpx, euroc or csv");
  expect_refusal(refine({"--reference", "nmea:" + path("nowhere")}), kNoInput, "nowhere");
  expect_refusal(refine({"--dof", "4"}), kUsage, "--reference");
}

/// Whether a process has a file open.
bool has_open(pid_t pid, const std::string& path) {
  std::error_code error;
  const fs::directory_iterator files(fs::path("/proc") / std::to_string(pid) / "fd", error);
  return std::any_of(begin(files), end(files), [&](const fs::directory_entry& file) {
    std::error_code closed;
    return fs::read_symlink(file, closed) == path;
  });
}

TEST_F(Refine, WritesTheRestAsItWasWhenItIsStopped) {
  recording_.frames = 60;
  recording_.write();
  ASSERT_EQ(run().exit_code, 0);
  const std::string observations = fs::canonical(path("run/observations.bin")).string();
  Program program({"refine", path("run"), "--out", path("refined")});
  // Observations are read once signals are caught.
  for (int i = 0; i < 60'000 && !has_open(program.pid(), observations); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 128 + SIGINT);
  EXPECT_THAT(result.out, HasSubstr("Refined in part: 60 frames"));
  EXPECT_THAT(result.err, HasSubstr("refinement was stopped by signal 2; what it did not reach is as the run had it"));
  const Json json = Json::parse(text_of(path("refined/run.json")));
  EXPECT_EQ(json.at("frames"), 60);
  EXPECT_EQ(json.at("exit_status"), 128 + SIGINT);
}

TEST_F(Refine, FollowsARunThatAsksForIt) {
  const ProgramResult result = run({"--refine", "batch"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json refined = Json::parse(text_of(path("run/run.json")));
  EXPECT_EQ(refined.at("dataset").at("refined_from"), path("run.online"));
  const Json online = Json::parse(text_of(path("run.online/run.json")));
  EXPECT_EQ(online.at("config").at("features").at("max_features"), 4000);
  EXPECT_EQ(online.at("config").at("segmentation").at("onnx").at("latency_frames"), 0);
}

TEST_F(Refine, FollowsARunAndPrintsTheRefinedOne) {
  const ProgramResult result = run({"--refine", "batch", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, text_of(path("run/run.json")));
}

TEST_F(Refine, FollowsARunIntoTheFolderInWhichItWasStarted) {
  fs::create_directories(path("here"));
  const ProgramResult result = run_in_shell("cd '" + path("here") + "' && $kinetrace run --dataset '" +
                                            recording_.dataset() + "' --segmentation none --refine batch --out .");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("here/run.json")));
  EXPECT_TRUE(fs::exists(path("here.online/run.json")));
  const ProgramResult dashed = run_in_shell("cd '" + path("here") + "' && $kinetrace run --dataset '" +
                                            recording_.dataset() + "' --segmentation none --refine batch --out=-x");
  ASSERT_EQ(dashed.exit_code, 0) << dashed.err;
  EXPECT_TRUE(fs::exists(path("here/-x/run.json")));
}

TEST_F(Refine, IsLeftOutAfterARunThatWasStopped) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string before = text_of(path("run/run.json"));
  recording_.frames = 120;
  recording_.write();
  Program program({"run", "--dataset", recording_.dataset(), "--segmentation", "none", "--refine", "batch", "--quiet",
                   "--out", path("run")});
  const fs::path rows = path("run.online/camera.tum");
  for (int i = 0; i < 60'000 && (!fs::exists(rows) || fs::file_size(rows) == 0); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 128 + SIGINT);
  EXPECT_THAT(result.err, HasSubstr("what it computed is in " + path("run.online")));
  EXPECT_EQ(text_of(path("run/run.json")), before);
}

TEST_F(Refine, FollowsARunWithTheSettingsThatItHas) {
  ASSERT_EQ(run({"--refine", "batch", "--set", "features.max_features=600"}).exit_code, 0);
  const Json online = Json::parse(text_of(path("run.online/run.json")));
  EXPECT_EQ(online.at("config").at("features").at("max_features"), 600);
  fs::remove_all(path("run"));
  expect_refusal(run({"--refine", "batch", "--set", "output.observations=false"}), kUsage, "leave that setting out");
  EXPECT_FALSE(fs::exists(path("run")));
}

TEST_F(Refine, FollowsARunWhoseConfigurationHasNoObservations) {
  std::ofstream(path("small.yaml")) << "output:\n  observations: false\n";
  const ProgramResult result = run({"--refine", "batch", "--config", path("small.yaml")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(path("run.online/observations.bin")));
}

}  // namespace
}  // namespace kinetrace::test
