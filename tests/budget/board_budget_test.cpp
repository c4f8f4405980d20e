// Promise to a board integrator: this many objects at this image size within this much memory, results published over
// DDS, as enforced by the kernel.
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "rendered_clip.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr std::uint64_t kMib = 1U << 20U;

struct Promise {
  const char* name;
  int width_px;
  int height_px;
  int objects;
  std::uint64_t budget_mib;
};

// For the tests' names. NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's.
void PrintTo(const Promise& promise, std::ostream* out) {
  *out << promise.name;
}

StereoGeometry rig(const Promise& promise) {
  const double f_px = 0.58 * promise.width_px;
  return {.fx_px = f_px,
          .fy_px = f_px,
          .cx_px = 0.5 * promise.width_px,
          .cy_px = 0.45 * promise.height_px,
          .baseline_m = 0.5,
          .width_px = promise.width_px,
          .height_px = promise.height_px};
}

// Moving vehicles side by side in two rows, all ahead.
StreetDrive traffic(const Promise& promise) {
  std::vector<Mover> movers;
  const int columns = (promise.objects + 1) / 2;
  for (int k = 0; k < promise.objects; ++k) {
    const double column = k % columns - 0.5 * (columns - 1);
    const int row = k / columns;
    movers.push_back({.size_m = {1.0, 1.2, 1.0},
                      .start_m = {1.9 * column, 0.9 - 1.6 * row, 9.0 + row},
                      .velocity_mps = {0.0, 0.0, 6.0}});
  }
  return StreetDrive(movers, rig(promise));
}

class BoardBudget : public ::testing::TestWithParam<Promise> {
 protected:
  void SetUp() override { clip_ = write_rendered_clip(folder_.path(), traffic(GetParam()), 10); }
  [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"run",
                                 "--dataset",
                                 clip_.dataset,
                                 "--segmentation",
                                 clip_.segmentation,
                                 "--out",
                                 (folder_.path() / "run").string(),
                                 "--publish",
                                 std::string(KINETRACE_SOURCE_DIR) + "/config/dds/loopback.yaml",
                                 "--loop",
                                 "12",
                                 "--quiet"};
    for (const std::string& setting : {"tracking.max_objects=" + std::to_string(GetParam().objects),
                                       "memory.budget_mib=" + std::to_string(GetParam().budget_mib)}) {
      all.insert(all.end(), {"--set", setting});
    }
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  [[nodiscard]] nlohmann::json report() const {
    return nlohmann::json::parse(std::ifstream(folder_.path() / "run/run.json"));
  }

  TempFolder folder_;
  RenderedClip clip_;
};

TEST_P(BoardBudget, HoldsInAGroupOfThatMuchMemory) {
  const auto group = ControlGroup::of_memory(GetParam().budget_mib * kMib);
  const ProgramResult result = run_kinetrace(command({}), group ? &*group : nullptr);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json run = report();
  EXPECT_EQ(run["frames"], 120);
  EXPECT_GE(run["counters"]["tracks_born"], GetParam().objects);
  EXPECT_LE(run["rss_peak_bytes"].get<std::uint64_t>(), GetParam().budget_mib * kMib);
  EXPECT_EQ(run["allocations_after_start"], 0);
  EXPECT_GT(run["counters"]["dds_frames"], 0);
  // Measured: five for each of four inflated image files. A run uses neither Ceres nor OpenCV.
  constexpr int kMaxOfCapture = 24;
  ASSERT_FALSE(run["foreign_allocations_per_frame_max"].empty());
  for (const auto& [stage, most] : run["foreign_allocations_per_frame_max"].items()) {
    EXPECT_LE(most, stage == "capture" ? kMaxOfCapture : 0) << stage;
  }
  if (!group) {
    GTEST_SKIP() << "the kernel does not let this process make control groups; peak memory was checked";
  }
}

TEST_P(BoardBudget, HoldsLive) {
  const auto group = ControlGroup::of_memory(GetParam().budget_mib * kMib);
  const ProgramResult result =
      run_kinetrace(command({"--set", "live.mode=on", "--set", "live.speed=20"}), group ? &*group : nullptr);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LE(report()["rss_peak_bytes"].get<std::uint64_t>(), GetParam().budget_mib * kMib);
  EXPECT_EQ(report()["allocations_after_start"], 0);
}

INSTANTIATE_TEST_SUITE_P(, BoardBudget,
                         ::testing::Values(Promise{"Of1242x375With8Objects", 1242, 375, 8, 64},
                                           Promise{"Of640x480With4Objects", 640, 480, 4, 40}),
                         [](const auto& promise) { return std::string(promise.param.name); });

TEST(BoardProfiles, AllFitTheirBudgetAndTheirBoard) {
  for (const char* board : {"raspberry-pi-5", "raspberry-pi-4", "jetson-orin-nano", "wearable-512"}) {
    const ProgramResult plan = run_kinetrace(
        {"plan", "--board", board, "--publish", std::string(KINETRACE_SOURCE_DIR) + "/config/dds/network.yaml"});
    EXPECT_EQ(plan.exit_code, 0) << plan.err;
    EXPECT_NE(plan.out.find("board.memory_mib"), std::string::npos) << plan.out;
    EXPECT_NE(plan.out.find("stacks"), std::string::npos) << plan.out;
    EXPECT_NE(plan.out.find("tracking.max_objects"), std::string::npos) << plan.out;
  }
}

TEST(BoardProfiles, AnUnknownOneIsAnsweredWithThoseThereAre) {
  const ProgramResult plan = run_kinetrace({"plan", "--board", "toaster"});
  EXPECT_EQ(plan.exit_code, 78);
  for (const char* part : {"--board toaster", "raspberry-pi-5", "wearable-512", "--config"}) {
    EXPECT_NE(plan.err.find(part), std::string::npos) << plan.err;
  }
}

TEST(BoardProfiles, ABudgetBeyondTheBoardIsRefused) {
  const ProgramResult plan = run_kinetrace({"plan", "--board", "wearable-512", "--set", "memory.budget_mib=513"});
  EXPECT_EQ(plan.exit_code, 78);
  EXPECT_NE(plan.err.find("board.memory_mib = 512"), std::string::npos) << plan.err;
}

}  // namespace
}  // namespace kinetrace::test
