// A whole run on a rendered street with one vehicle, under every camera fault: path and times stay correct, the
// vehicle's track continues or ends, and the run reports the fault.
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "rendered_clip.hpp"
#include "street_drive.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr int kFrames = 36;

struct FaultyRun {
  ProgramResult program;
  nlohmann::json report;
  std::map<int, Eigen::Vector3d> camera;      ///< Position by frame, from its time.
  std::map<int, std::set<int>> track_frames;  ///< Frames in which a track has a row, by id.

  [[nodiscard]] std::vector<int> frames() const {
    std::vector<int> numbers;
    for (const auto& [frame, position] : camera) {
      numbers.push_back(frame);
    }
    return numbers;
  }
  /// Count of a reason in the health report.
  [[nodiscard]] int count(const std::string& reason) const {
    for (const auto& entry : report["health"]["reasons"]) {
      if (entry["reason"] == reason) {
        return entry["count"];
      }
    }
    return 0;
  }
};

class Fault : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    clip_ = new RenderedClip(write_rendered_clip(folder_->path(), kFrames));
  }
  static void TearDownTestSuite() {
    delete clip_;
    delete folder_;
  }

  /// Runs with these faults and checks the properties that hold under all faults.
  static FaultyRun run(const std::string& faults, bool path_can_be_right = true) {
    const std::filesystem::path out = folder_->path() / "out";
    std::vector<std::string> arguments{"run",   "--dataset",  clip_->dataset, "--segmentation", clip_->segmentation,
                                       "--out", out.string(), "--quiet"};
    if (!faults.empty()) {
      arguments.insert(arguments.end(), {"--fault", faults});
    }
    FaultyRun run{.program = run_kinetrace(arguments), .report = {}, .camera = {}, .track_frames = {}};
    EXPECT_EQ(run.program.exit_code, 0) << run.program.err;
    std::ifstream report(out / "run.json");
    run.report = nlohmann::json::parse(report, nullptr, false);
    read_camera(out / "camera.tum", run);
    read_tracks(out / "objects.csv", run);
    EXPECT_EQ(run.report["frames"], run.camera.size());
    if (path_can_be_right) {
      expect_path(run);
    }
    expect_tracks_kept_or_ended(run);
    return run;
  }
  /// A tolerated fault allocates no memory. The program may not count: then there is nothing to check.
  static void expect_no_allocations(const FaultyRun& run) {
    const nlohmann::json& counted = run.report["allocations_after_start"];
    EXPECT_EQ(counted.is_null() ? 0 : counted.get<int>(), 0);
  }

 private:
  static void read_camera(const std::filesystem::path& path, FaultyRun& run) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      double t = 0.0;
      Eigen::Vector3d position;
      std::istringstream(line) >> t >> position.x() >> position.y() >> position.z();
      const double frame = t / StreetDrive::kFrame_s;
      EXPECT_NEAR(frame, std::round(frame), 1e-6) << "a time that no frame has";
      EXPECT_TRUE(run.camera.emplace(static_cast<int>(std::lround(frame)), position).second) << "a time twice";
    }
  }
  static void read_tracks(const std::filesystem::path& path, FaultyRun& run) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      int frame = 0;
      long long time_ns = 0;
      int id = 0;
      ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lld,%d", &frame, &time_ns, &id), 3) << line;
      EXPECT_EQ(time_ns, frame * 100'000'000LL) << line;
      run.track_frames[id].insert(frame);
    }
  }
  // The pose is right only if every dt was: motion is predicted over it.
  static void expect_path(const FaultyRun& run) {
    const Se3 T_first_world = StreetDrive::T_world_cam(run.camera.begin()->first).inverse();
    for (const auto& [frame, position] : run.camera) {
      const Eigen::Vector3d truth = (T_first_world * StreetDrive::T_world_cam(frame)).translation;
      EXPECT_LT((position - truth).norm(), 0.4) << "frame " << frame;
    }
  }
  static void expect_tracks_kept_or_ended(const FaultyRun& run) {
    ASSERT_FALSE(run.track_frames.empty()) << "the vehicle was not seen at all";
    const int last = run.camera.rbegin()->first;
    int gone = 0;
    for (const auto& [id, frames] : run.track_frames) {
      gone += frames.count(last) == 0 ? 1 : 0;
    }
    EXPECT_LE(gone, run.report["counters"]["tracks_ended"].get<int>()) << "a track vanished without having ended";
    EXPECT_LE(run.track_frames.size(), 2U) << "one vehicle, and after a fault perhaps a second track of it";
  }

 protected:
  static TempFolder* folder_;
  static RenderedClip* clip_;
};
TempFolder* Fault::folder_ = nullptr;
RenderedClip* Fault::clip_ = nullptr;

std::vector<int> all_but(const std::set<int>& missing) {
  std::vector<int> frames;
  for (int frame = 0; frame < kFrames; ++frame) {
    if (missing.count(frame) == 0) {
      frames.push_back(frame);
    }
  }
  return frames;
}

TEST_F(Fault, NoneIsOk) {
  const FaultyRun fine = run("");
  expect_no_allocations(fine);
  EXPECT_EQ(fine.report["health"]["worst"], "ok");
  EXPECT_EQ(fine.report["health"]["camera"], "streaming");
  EXPECT_TRUE(fine.report["health"]["reasons"].empty());
  EXPECT_EQ(fine.frames(), all_but({}));
  EXPECT_EQ(fine.track_frames.size(), 1U);
}

TEST_F(Fault, UnplugIsWaitedFor) {
  const FaultyRun gone = run("unplug@14-16:3");
  EXPECT_EQ(gone.frames(), all_but({14, 15, 16}));
  EXPECT_EQ(gone.report["health"]["worst"], "lost");
  EXPECT_EQ(gone.count("camera_lost"), 1);
  EXPECT_EQ(gone.report["counters"]["camera_recoveries"], 1);
  EXPECT_THAT(gone.program.err, ::testing::AllOf(::testing::HasSubstr("waiting"), ::testing::HasSubstr("is back")));
}

TEST_F(Fault, AStalledStreamContinues) {
  const FaultyRun stuck = run("stuck@14-15");
  EXPECT_EQ(stuck.frames(), all_but({14, 15}));
  EXPECT_EQ(stuck.report["health"]["worst"], "degraded");
  EXPECT_EQ(stuck.count("camera_stalled"), 1);
}

TEST_F(Fault, SlowIsOnlySlow) {
  const FaultyRun slow = run("slow@14-16:50");
  EXPECT_EQ(slow.frames(), all_but({}));
  EXPECT_EQ(slow.report["health"]["worst"], "ok");
}

TEST_F(Fault, DroppedFramesWidenTheStep) {
  const FaultyRun dropped = run("drop@14-15,drop@20");
  expect_no_allocations(dropped);
  EXPECT_EQ(dropped.frames(), all_but({14, 15, 20}));
  EXPECT_EQ(dropped.count("frames_lost"), 3);
}

TEST_F(Fault, DuplicatesAreLeftOut) {
  const FaultyRun twice = run("duplicate@14-15");
  expect_no_allocations(twice);
  EXPECT_EQ(twice.frames(), all_but({}));
  EXPECT_EQ(twice.count("frames_repeated"), 2);
}

TEST_F(Fault, LateFramesAreLeftOut) {
  const FaultyRun reordered = run("reorder@14");
  expect_no_allocations(reordered);
  EXPECT_EQ(reordered.frames(), all_but({14}));
  EXPECT_EQ(reordered.count("frames_repeated"), 1);
  const FaultyRun last = run("reorder@" + std::to_string(kFrames - 1));
  EXPECT_EQ(last.frames(), all_but({})) << "nothing follows that it could come after";
}

TEST_F(Fault, CutOffImagesAreLeftOut) {
  const FaultyRun cut = run("corrupt@14-15");
  expect_no_allocations(cut);
  EXPECT_EQ(cut.frames(), all_but({14, 15}));
  EXPECT_EQ(cut.count("frames_damaged"), 2);
  const FaultyRun a_little = run("corrupt@14-15:5");
  EXPECT_EQ(a_little.frames(), all_but({14, 15}));
  EXPECT_EQ(a_little.count("frames_damaged"), 2);
}

TEST_F(Fault, CamerasOutOfStepAreNoticed) {
  // Long enough to be detected. Views of different moments give wrong depths, and hence a wrong path.
  const FaultyRun late = run("desync@8-35", false);
  EXPECT_EQ(late.frames(), all_but({}));
  EXPECT_GE(late.count("views_out_of_step"), 1);
  EXPECT_EQ(late.report["health"]["worst"], "degraded");
}

TEST_F(Fault, ClockJumpsDoNotReachThePath) {
  for (const char* jump : {"clock@14:3600", "clock@14:-3600", "clock@14:-0.5", "clock@14:0.07"}) {
    const FaultyRun jumped = run(jump);
    expect_no_allocations(jumped);
    EXPECT_EQ(jumped.frames(), all_but({})) << jump;
    EXPECT_EQ(jumped.count("clock_jumped"), 1) << jump;
  }
}

TEST_F(Fault, WrongSizeIsLeftOut) {
  const FaultyRun small = run("size@14-15");
  expect_no_allocations(small);
  EXPECT_EQ(small.frames(), all_but({14, 15}));
  EXPECT_EQ(small.count("frames_of_wrong_size"), 2);
}

TEST_F(Fault, SeveralAtOnceAndAtRandom) {
  const FaultyRun storm =
      run("drop@0-35%10,duplicate@0-35%10,reorder@0-35%10,corrupt@5-35%10,stuck@5-35%5,clock@18:-100,unplug@25,seed=4");
  EXPECT_GE(storm.camera.size(), 20U);
  EXPECT_EQ(storm.report["health"]["worst"], "lost");
}

TEST_F(Fault, TheSameFaultsGiveTheSameRun) {
  const char* plan = "drop@0-35%20,reorder@0-35%10,seed=9";
  EXPECT_EQ(run(plan).camera, run(plan).camera);
}

TEST_F(Fault, AWrongPlanIsAUsageError) {
  const ProgramResult result = run_kinetrace(
      {"run", "--dataset", clip_->dataset, "--out", (folder_->path() / "never").string(), "--fault", "explode@3"});
  EXPECT_EQ(result.exit_code, 64);
  EXPECT_THAT(result.err, ::testing::HasSubstr("explode"));
  EXPECT_FALSE(std::filesystem::exists(folder_->path() / "never"));
}

}  // namespace
}  // namespace kinetrace::test
