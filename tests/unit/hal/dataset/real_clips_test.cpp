// Real recordings, if available: KINETRACE_DATA names their folder.
#include <cstdlib>
#include <filesystem>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "kinetrace/hal/cut_off_detector.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"

namespace kinetrace::hal {
namespace {

class RealClips : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* root = std::getenv("KINETRACE_DATA");
    if (root == nullptr || !std::filesystem::is_directory(root)) {
      GTEST_SKIP() << "KINETRACE_DATA does not name a folder of real recordings";
    }
    root_ = root;
  }
  // Plays and rectifies everything; returns the geometry.
  StereoGeometry play(const DatasetSpec& spec, std::uint64_t expected_frames) {
    const Result<Dataset> dataset = open_dataset(spec);
    if (!dataset) {
      ADD_FAILURE() << dataset.error().message;
      return {};
    }
    Arena arena(FileStereoCamera::required_bytes(*dataset, {}) + Rectifier::required_bytes(dataset->calibration, {}));
    CutOffDetector cut_off;
    CutOffDetector rectified_cut_off;  // Black borders are no damage.
    Rectifier rectifier = Rectifier::create(dataset->calibration, {}, arena).value();
    FileStereoCamera camera = FileStereoCamera::create(*dataset, {}, arena).value();
    EXPECT_TRUE(camera.open() && camera.start());
    while (const auto frame = camera.next(std::chrono::milliseconds(100))) {
      EXPECT_FALSE(cut_off.examine(*frame)) << frame->name;
      const auto pair = rectifier.process(*frame);
      if (!pair) {
        ADD_FAILURE() << pair.error().message;
        break;
      }
      EXPECT_FALSE(rectified_cut_off.examine({pair->frame_index, pair->timestamp_ns, {}, pair->left, pair->right}))
          << frame->name;
      EXPECT_EQ(pair->left.width, rectifier.geometry().width_px);
      if (camera.counters().frames_delivered == 1) {
        EXPECT_GT(row_agreement(*pair), 0.8);
      }
    }
    EXPECT_EQ(camera.counters().frames_delivered, expected_frames);
    EXPECT_EQ(camera.counters().skipped_unreadable, 0U);
    return rectifier.geometry();
  }

  // Share of corners whose best match in the right image lies on their own row rather than two rows off.
  static double row_agreement(const RectifiedPair& pair) {
    int same_row = 0;
    int all = 0;
    for (int y = 40; y < pair.left.height - 40; y += 16) {
      for (int x = 160; x < pair.left.width - 40; x += 16) {
        if (cornerness(pair.left, x, y) < kMinCornerness) {
          continue;
        }
        const double here = best_difference(pair, x, y, 0);
        ++all;
        same_row += here <= best_difference(pair, x, y, 2) && here <= best_difference(pair, x, y, -2) ? 1 : 0;
      }
    }
    return all == 0 ? 0.0 : static_cast<double>(same_row) / all;
  }

  std::filesystem::path root_;

 private:
  static constexpr int kRadius = 6;
  static constexpr double kMinCornerness = 8000;

  // The smaller eigenvalue of the structure tensor (Shi and Tomasi, "Good features to track", 1994).
  static double cornerness(GrayView image, int x, int y) {
    Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();
    for (int v = y - kRadius; v <= y + kRadius; ++v) {
      for (int u = x - kRadius; u <= x + kRadius; ++u) {
        const Eigen::Vector2d gradient(image.at(u + 1, v) - image.at(u - 1, v),
                                       image.at(u, v + 1) - image.at(u, v - 1));
        tensor += gradient * gradient.transpose() / 4;
      }
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(tensor).eigenvalues()[0];
  }

  static double best_difference(const RectifiedPair& pair, int x, int y, int row_offset) {
    double best = std::numeric_limits<double>::max();
    for (int disparity = 0; disparity < 128; ++disparity) {
      best = std::min(best, difference(pair, x, y, disparity, row_offset));
    }
    return best;
  }

  // Sum of absolute differences of two patches, each less its mean.
  static double difference(const RectifiedPair& pair, int x, int y, int disparity, int row_offset) {
    constexpr int kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
    const auto between = [&](int du, int dv) {
      return pair.left.at(x + du, y + dv) - pair.right.at(x + du - disparity, y + dv + row_offset);
    };
    double mean = 0;
    double sum = 0;
    for (int pass = 0; pass < 2; ++pass) {
      for (int dv = -kRadius; dv <= kRadius; ++dv) {
        for (int du = -kRadius; du <= kRadius; ++du) {
          (pass == 0 ? mean : sum) +=
              pass == 0 ? static_cast<double>(between(du, dv)) / kPixels : std::abs(between(du, dv) - mean);
        }
      }
    }
    return sum;
  }
};

TEST_F(RealClips, UnrectifiedKittiDrive) {
  const StereoGeometry g = play(
      {.layout = DatasetLayout::kKittiRaw, .path = root_ / "kitti_raw/2011_09_26/2011_09_26_drive_0039_extract"}, 44);
  EXPECT_NEAR(g.fx_px, 721.5377, 1e-4);
  EXPECT_NEAR(g.cx_px, 609.5593, 1e-4);
  EXPECT_NEAR(g.cy_px, 172.8540, 1e-4);
  EXPECT_NEAR(g.baseline_m, 387.5744 / 721.5377, 1e-6);
  EXPECT_EQ(g.width_px, 1242);
  EXPECT_EQ(g.height_px, 375);
}

TEST_F(RealClips, KittiOdometryGray) {
  const StereoGeometry g =
      play({.layout = DatasetLayout::kKittiOdometry, .path = root_ / "kitti_odometry", .sequence = "ramp"}, 31);
  EXPECT_NEAR(g.baseline_m, 386.1448 / 718.856, 1e-6);
}

TEST_F(RealClips, KittiOdometryColour) {
  const StereoGeometry g =
      play({.layout = DatasetLayout::kKittiOdometry, .path = root_ / "kitti_odometry", .sequence = "oncoming"}, 14);
  EXPECT_NEAR(g.baseline_m, 0.5333, 1e-4);
}

TEST_F(RealClips, Euroc) {
  const StereoGeometry g = play({.layout = DatasetLayout::kEuroc, .path = root_ / "euroc/V1_01_easy"}, 10);
  EXPECT_NEAR(g.baseline_m, 0.11007, 1e-4);
  EXPECT_EQ(g.width_px, 752);
}

}  // namespace
}  // namespace kinetrace::hal
