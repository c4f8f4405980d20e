// `kinetrace calibrate` on two live USB cameras that show a board, held still in one place after the other.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.hpp"
#include "program.hpp"
#include "temp_folder.hpp"
#include "uvc/simulated_uvc_camera.hpp"
#include "uvc/uvc_pair.hpp"

namespace kinetrace::test {
namespace {

constexpr std::size_t kPixels = 320UL * 240UL;

/// The pixels of all PGM files of a folder, by name.
std::vector<hal::test::Bytes> pictures_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<hal::test::Bytes> pictures;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    const std::string content{std::istreambuf_iterator<char>(file), {}};
    pictures.emplace_back(content.end() - static_cast<std::ptrdiff_t>(kPixels), content.end());
  }
  return pictures;
}

TEST(LiveCalibrate, FindsTheRigOfTwoCamerasThatShowABoard) {
  constexpr int kFramesEach = 3;
  hal::test::UvcPair& pair = hal::test::UvcPair::instance();
  pair.left.show(pictures_in(std::string(KINETRACE_BOARD) + "/left"), kFramesEach);
  pair.right.show(pictures_in(std::string(KINETRACE_BOARD) + "/right"), kFramesEach);
  hal::test::UvcPair::wait_until_listed(hal::CaptureBackend::kV4l2, 2);
  const TempFolder folder;
  // No calibration is named: there is none yet.
  std::ofstream(folder.file("camera.yaml"))
      << "source: v4l2\ndevices:\n  left: " << pair.config(hal::CaptureBackend::kV4l2, 0).device
      << "\n  right: " << pair.config(hal::CaptureBackend::kV4l2, 1).device
      << "\nimage:\n  format: grey8\n  width_px: 320\n  height_px: 240\n  rate_hz: 5\n"
         "pairing:\n  tolerance_ms: 60\ntimeouts:\n  stall_ms: 4000\n  lost_ms: 4000\n";
  const ProgramResult result =
      run_kinetrace({"calibrate", "--camera", folder.file("camera.yaml"), "--target", "charuco:8x6:0.04:0.031",
                     "--seconds", "26", "--out", folder.file("out")});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  const auto rig = hal::read_rig_calibration(folder.file("out/calibration.yaml"), 320, 240);
  ASSERT_TRUE(rig) << rig.error().message;
  const hal::RigCalibration truth = calibration::test::true_rig(calibration::Lens::kRadialTangential, 0.5);
  // Small images, few views.
  EXPECT_NEAR(rig->left.fx_px, truth.left.fx_px, 3e-3 * truth.left.fx_px) << result.out;
  EXPECT_NEAR(rig->right.fx_px, truth.right.fx_px, 3e-3 * truth.right.fx_px);
  const double turn_rad = left_difference(truth.T_right_left, rig->T_right_left).head<3>().norm();
  EXPECT_LT(turn_rad * 180.0 / std::numbers::pi, 0.15);
  std::printf("%s", result.out.c_str());
}

}  // namespace
}  // namespace kinetrace::test
