// `kinetrace calibrate` from outside, on rendered targets whose truth is known.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "board_scene.hpp"
#include "program.hpp"
#include "rendered_board.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using calibration::Lens;
using calibration::test::board_poses;
using calibration::test::Motion;
using calibration::test::true_rig;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr int kScale = 2;  // 1280x960.
constexpr const char* kBoard = "charuco:11x8:0.03:0.022:DICT_4X4_100";

void write_pgm(const std::string& path, const BoardImage& image) {
  std::ofstream file(path, std::ios::binary);
  file << "P5\n" << image.width_px << " " << image.height_px << "\n255\n";
  file.write(reinterpret_cast<const char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size()));
}

/// A folder of image pairs without any calibration.
class Calibrate : public ::testing::Test {
 protected:
  void record(const std::string& board, Lens lens, const Motion& motion, const BoardImageFaults& faults = {},
              int scale = kScale) {
    const auto target = calibration::parse_target(board);
    ASSERT_TRUE(target) << target.error().message;
    const hal::RigCalibration rig = true_rig(lens, scale);
    const BoardRenderer left(*target, rig.left);
    const BoardRenderer right(*target, rig.right);
    std::uint32_t seed = 1;
    for (const Se3& pose : board_poses(rig, *target, motion, 7)) {
      std::string name = std::to_string(seed / 2);
      name.insert(0, 6 - name.size(), '0').append(".pgm");
      BoardImageFaults each = faults;
      each.covered = (seed / 2) % 3 == 0 ? faults.covered : 0.0;
      write_pgm(folder_.file("images/left/" + name), left.render(pose, each, seed++));
      write_pgm(folder_.file("images/right/" + name), right.render(rig.T_right_left * pose, each, seed++));
    }
  }

  [[nodiscard]] ProgramResult calibrate(const std::string& board, const std::string& lens) const {
    return run_kinetrace({"calibrate", "--dataset", "folder:" + (folder_.path() / "images").string(), "--target", board,
                          "--lens", lens, "--out", out()});
  }
  [[nodiscard]] std::string out() const { return (folder_.path() / "out").string(); }

  /// Checks the promised accuracy of a calibration of these images.
  void expect_truth(Lens lens) const {
    const hal::RigCalibration truth = true_rig(lens, kScale);
    const auto rig = hal::read_rig_calibration(out() + "/calibration.yaml", 1280, 960);
    ASSERT_TRUE(rig) << rig.error().message;
    constexpr double kFocal = 1e-3;
    EXPECT_NEAR(rig->left.fx_px, truth.left.fx_px, kFocal * truth.left.fx_px);
    EXPECT_NEAR(rig->left.fy_px, truth.left.fy_px, kFocal * truth.left.fy_px);
    EXPECT_NEAR(rig->right.fx_px, truth.right.fx_px, kFocal * truth.right.fx_px);
    EXPECT_NEAR(rig->right.fy_px, truth.right.fy_px, kFocal * truth.right.fy_px);
    const Vector6d pose = left_difference(truth.T_right_left, rig->T_right_left);
    const double turn_deg = pose.head<3>().norm() * 180.0 / std::numbers::pi;
    EXPECT_LT(turn_deg, 0.01);
    EXPECT_LT(pose.tail<3>().norm(), 3e-4);
    const Json report = Json::parse(text_of(out() + "/calibration.json"));
    EXPECT_LT(report["corner_sigma_px"], 0.1);
    EXPECT_LT(report["left_out"]["epipolar_rms_px"], 0.15);
    EXPECT_LT(std::abs(report["left_out"]["length_error"].get<double>()), 1e-3);
    std::printf("focal %+.4f %% %+.4f %%, rotation %.4f deg (sigma %.4f), corners %.3f px, rows left out %.3f px\n",
                100 * (rig->left.fx_px / truth.left.fx_px - 1), 100 * (rig->right.fx_px / truth.right.fx_px - 1),
                turn_deg, report["rotation_sigma_deg"].get<double>(), report["corner_sigma_px"].get<double>(),
                report["left_out"]["epipolar_rms_px"].get<double>());
  }

  TempFolder folder_;
};

constexpr int kSmall = 1;
constexpr Motion kGoodMotion{.views = 40, .max_tilt_rad = 0.7, .near_m = 0.3, .far_m = 0.7, .spread = 0.9};

TEST_F(Calibrate, WhereNothingCanBeWrittenNoImageIsLookedAt) {
  for (const char* view : {"left", "right"}) {
    for (const char* name : {"000000.pgm", "000001.pgm"}) {
      const std::vector<std::uint8_t> black(std::size_t{320} * 240);
      write_pgm(folder_.file(std::string("images/") + view + "/" + name), {black, 320, 240});
    }
  }
  const std::string images = "folder:" + (folder_.path() / "images").string();
  const std::string file = (folder_.path() / "images/left/000000.pgm").string();
  for (const std::vector<std::string>& source :
       {std::vector<std::string>{"--dataset", images, "--target", kBoard}, {"--self", images, "--baseline", "0.1"}}) {
    std::vector<std::string> arguments{"calibrate"};
    arguments.insert(arguments.end(), source.begin(), source.end());
    EXPECT_EQ(run_kinetrace(arguments).exit_code, 64) << "no --out";
    arguments.insert(arguments.end(), {"--out", file});
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, kCannotCreate) << result.err;
    EXPECT_THAT(result.err, HasSubstr(file + ": "));
    EXPECT_THAT(result.err, HasSubstr("name another folder"));
  }
  EXPECT_THAT(run_kinetrace({"calibrate", "--self", images, "--baseline", "nan", "--out", out()}).err,
              HasSubstr("must be in [0.001 - 10], got nan"));
}

TEST_F(Calibrate, RefusesWhatItDoesNotUseWithoutATarget) {
  for (const std::vector<std::string>& unused :
       {std::vector<std::string>{"--lens", "fisheye"}, {"--seconds", "1"}, {"--fault", "drop@1"}, {"--loop", "2"}}) {
    std::vector<std::string> arguments{"calibrate", "--self", "folder:nowhere", "--baseline", "0.1", "--out", out()};
    arguments.insert(arguments.end(), unused.begin(), unused.end());
    expect_refusal(run_kinetrace(arguments), kUsage, unused.front());
  }
}

TEST_F(Calibrate, ChoosesAmongTheContentsOfEitherRecording) {
  for (const char* recording : {"--dataset", "--self"}) {
    for (const char* choice : {"--sequence", "--cameras"}) {
      const bool is_self = recording == std::string("--self");
      const ProgramResult result =
          run_kinetrace({"calibrate", recording, "kitti-raw:nowhere", choice, "color",
                         is_self ? "--baseline" : "--target", is_self ? "0.1" : kBoard, "--out", out()});
      expect_refusal(result, kNoInput, "nowhere");
    }
  }
  expect_refusal(
      run_kinetrace({"calibrate", "--camera", "rig.yaml", "--sequence", "1", "--target", kBoard, "--out", out()}),
      kUsage, "--camera");
}

TEST_F(Calibrate, AFileOfAnotherKindIsKept) {
  const std::vector<std::uint8_t> black(std::size_t{320} * 240);
  for (const char* image : {"left/000000.pgm", "left/000001.pgm", "right/000000.pgm", "right/000001.pgm"}) {
    write_pgm(folder_.file(std::string("images/") + image), {black, 320, 240});
  }
  for (const char* name : {"calibration.yaml", "camchain.yaml", "calibration.json", "calibration.png"}) {
    const std::string file = folder_.file(std::string("out/") + name);
    std::ofstream(file) << "notes: mine\n";
    expect_refusal(calibrate(kBoard, "radtan"), kCannotCreate, file + ": is there already");
    EXPECT_EQ(text_of(file), "notes: mine\n");
    std::filesystem::remove(file);
  }
  const std::string drawing = folder_.file("board.svg");
  const auto draw = [&] { return run_kinetrace({"calibrate", "--target", kBoard, "--draw", drawing}); };
  std::ofstream(drawing) << "K1: [1]\n";
  expect_refusal(draw(), kCannotCreate, drawing + ": is there already, and is no drawing of a target");
  EXPECT_EQ(text_of(drawing), "K1: [1]\n");
  std::filesystem::remove(drawing);
  EXPECT_EQ(draw().exit_code, 0);
  EXPECT_EQ(draw().exit_code, 0) << "a drawing is replaced";
  expect_refusal(run_kinetrace({"calibrate", "--target", kBoard, "--draw", "board.png"}), kUsage,
                 "--draw: board.png would be no png; name it .svg");
}

TEST_F(Calibrate, FindsARigFromAPartlyCoveredCharucoBoard) {
  record(kBoard, Lens::kRadialTangential, kGoodMotion, {.covered = 0.4});
  const ProgramResult result = calibrate(kBoard, "radtan");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("checked  on "));
  expect_truth(Lens::kRadialTangential);
  EXPECT_TRUE(std::filesystem::exists(out() + "/calibration.png"));
  const auto kalibr = hal::read_rig_calibration(out() + "/camchain.yaml", 1280, 960);
  EXPECT_TRUE(kalibr) << kalibr.error().message;
}

TEST_F(Calibrate, FindsARigFromAChessboard) {
  record("chessboard:9x6:0.03", Lens::kRadialTangential5, kGoodMotion);
  const ProgramResult result = calibrate("chessboard:9x6:0.03", "radtan5");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_truth(Lens::kRadialTangential5);
  // Kalibr has no k3.
  EXPECT_FALSE(std::filesystem::exists(out() + "/camchain.yaml"));
}

TEST_F(Calibrate, FindsFisheyeLensesFromAGridOfTags) {
  Motion motion = kGoodMotion;
  motion.near_m = 0.2;
  motion.far_m = 0.45;
  record("aprilgrid:6x5:0.05:0.3", Lens::kFisheye, motion);
  const ProgramResult result = calibrate("aprilgrid:6x5:0.05:0.3", "fisheye");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_truth(Lens::kFisheye);
}

TEST_F(Calibrate, FindsRationalLenses) {
  record(kBoard, Lens::kRational, kGoodMotion);
  const ProgramResult result = calibrate(kBoard, "rational");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_truth(Lens::kRational);
}

TEST_F(Calibrate, RefusesTooFewViews) {
  Motion motion = kGoodMotion;
  motion.views = 6;
  record(kBoard, Lens::kRadialTangential, motion, {}, kSmall);
  expect_refusal(calibrate(kBoard, "radtan"), kBadData, "views are too few, at least 10 are needed");
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(Calibrate, RefusesViewsThatAreTooFlat) {
  Motion motion = kGoodMotion;
  motion.views = 20;
  motion.max_tilt_rad = 0.03;
  record(kBoard, Lens::kRadialTangential, motion, {}, kSmall);
  expect_refusal(calibrate(kBoard, "radtan"), kBadData, "too flat");
}

TEST_F(Calibrate, RefusesViewsThatAreTooSimilar) {
  Motion motion = kGoodMotion;
  motion.views = 25;
  motion.near_m = 0.5;
  motion.far_m = 0.51;
  motion.spread = 0.02;
  motion.max_tilt_rad = 0.05;
  record(kBoard, Lens::kRadialTangential, motion, {}, kSmall);
  expect_refusal(calibrate(kBoard, "radtan"), kBadData, "too similar");
}

TEST_F(Calibrate, RefusesImagesWithoutTheTarget) {
  Motion motion = kGoodMotion;
  motion.views = 3;
  record(kBoard, Lens::kRadialTangential, motion, {}, kSmall);
  expect_refusal(calibrate("chessboard:5x4:0.03", "radtan"), kBadData, "0 views are too few");
}

// As installed without the calibration package.
TEST_F(Calibrate, NamesThePackageThatIsMissing) {
  const std::string alone = folder_.file("kinetrace");
  std::filesystem::copy_file(KINETRACE_PROGRAM, alone);
  const ProgramResult result =
      run_in_shell(alone + " calibrate --dataset folder:x --target chessboard:9x6:0.03 --out y");
  expect_refusal(result, kNoInput, "calibrating needs the package kinetrace-calibration");
}

TEST_F(Calibrate, RefusesATargetThatIsNotUnderstood) {
  expect_refusal(calibrate("chessboard:9x6", "radtan"), kUsage, "target 'chessboard:9x6' is not understood");
  expect_refusal(calibrate("chessboard:9x6:30", "radtan"), kUsage, "give it in metres");
  expect_refusal(calibrate("charuco:9x6:0.03:0.04", "radtan"), kUsage, "does not fit into a square");
}

}  // namespace
}  // namespace kinetrace::test
