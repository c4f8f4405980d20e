// A real drive on the map: its recorded GPS/INS poses stand for a receiver. Skipped where the recording is absent.
#include <cmath>

#include <gtest/gtest.h>

#include "clip_run.hpp"
#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::test {
namespace {

constexpr std::int64_t kFrame_ns = 103'000'000;  // KITTI's cameras: 9.7 Hz.
constexpr double kTimeOffset_s = 0.7;

/// Fixes in the receiver's clock, under an arbitrary heading.
std::vector<geo::Fix> recorded_fixes(const std::filesystem::path& drive) {
  Eigen::Matrix3d R_map_world;
  R_map_world << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  R_map_world = so3_exp(2.5 * Eigen::Vector3d::UnitZ()) * R_map_world;
  std::vector<geo::Fix> fixes;
  for (const Se3& pose : read_kitti_poses(drive / "camera_poses.txt")) {
    const auto time_ns = static_cast<std::int64_t>(fixes.size()) * kFrame_ns;
    fixes.push_back(
        {time_ns - std::llround(kTimeOffset_s * 1e9), R_map_world * pose.translation, Eigen::Vector3d::Constant(0.05)});
  }
  return fixes;
}

TEST(RealMaps, DriveLiesOnItsRecordedPoses) {
  const auto data = data_folder();
  if (!data) {
    GTEST_SKIP() << "no recordings: set KINETRACE_DATA";
  }
  for (const char* name : {"2011_09_26_drive_0039_extract", "2011_09_26_drive_0039_early_extract"}) {
    const std::filesystem::path drive = *data / "kitti_raw/2011_09_26" / name;
    pipeline::PipelineConfig config;
    config.segmentation.mode = segmentation::SegmentationMode::kMotion;
    const ClipRun run = run_clip({.layout = hal::DatasetLayout::kKittiRaw, .path = drive}, config);
    std::vector<geo::PathPose> path;
    for (std::size_t i = 0; i < run.camera.size(); ++i) {
      path.push_back({run.frames[i] * kFrame_ns, run.camera[i].T_world_cam});
    }
    const auto alignment = geo::align(path, recorded_fixes(drive), {.freedom = geo::Freedom::kYaw});
    ASSERT_TRUE(alignment) << alignment.error().message;
    EXPECT_EQ(alignment->verdict, geo::Verdict::kAligned) << alignment->reason;
    RecordProperty(std::string(name) + "_noise_m", std::to_string(alignment->horizontal_noise_m));
    RecordProperty(std::string(name) + "_offset_s", std::to_string(alignment->time_offset_s - kTimeOffset_s));
    // GPS/INS jitters by some centimetres, and the camera drifts by as much.
    EXPECT_LT(alignment->horizontal_noise_m, 0.15) << name;
    EXPECT_NEAR(alignment->scale, 1.0, 0.015) << name;
    EXPECT_LT(std::abs(alignment->time_offset_s - kTimeOffset_s), 0.05 + 3.0 * alignment->time_offset_sigma_s) << name;
  }
}

}  // namespace
}  // namespace kinetrace::test
