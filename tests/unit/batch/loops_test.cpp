// Loop closure: candidate frames, relative poses from two pictures of one place, and correction of the path.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "loops/loop_closure.hpp"
#include "loops/pose_information.hpp"
#include "loops/revisits.hpp"

namespace kinetrace::batch {
namespace {

const StereoGeometry kGeometry{400.0, 400.0, 319.5, 119.5, 0.5, 640, 240};
const AdjustmentOptions kOptions{.threads = 1, .keep_going = [] { return true; }};

/// A camera that drives forward by `step_m` a frame, `there` frames, and backwards the same way.
std::vector<Se3> there_and_back(int there, double step_m) {
  std::vector<Se3> T_world_cam;
  for (int k = 0; k < 2 * there - 1; ++k) {
    T_world_cam.push_back({Eigen::Matrix3d::Identity(), {0.0, 0.0, step_m * std::min(k, 2 * there - 2 - k)}});
  }
  return T_world_cam;
}

std::vector<Keyframe> every_frame(const std::vector<Se3>& T_world_cam, double depth_m) {
  std::vector<Keyframe> keyframes;
  for (std::size_t row = 0; row < T_world_cam.size(); ++row) {
    keyframes.push_back({.row = row, .depth_m = depth_m});
    if (row > 0) {
      keyframes.back().travelled_m =
          keyframes[row - 1].travelled_m + (T_world_cam[row].translation - T_world_cam[row - 1].translation).norm();
    }
  }
  return keyframes;
}

TEST(Revisits, AreFramesThatShowWhatWasLeft) {
  const std::vector<Se3> path = there_and_back(21, 1.0);
  const auto revisits = find_revisits(every_frame(path, 10.0), path);
  // It returns from 20 m: places before 10 m had left the view, and are in view again from 12.4 m on.
  constexpr std::size_t kBack = 28;
  for (std::size_t k = 0; k < kBack; ++k) {
    EXPECT_TRUE(revisits[k].empty()) << k;
  }
  for (std::size_t k = kBack; k < revisits.size(); ++k) {
    ASSERT_FALSE(revisits[k].empty()) << k;
    for (const std::size_t place : revisits[k]) {
      EXPECT_NEAR(path[place].translation.z(), path[k].translation.z(), 4.0);
    }
  }
}

TEST(Revisits, AllowForDriftAndForStepsInTheDark) {
  std::vector<Se3> path = there_and_back(21, 1.0);
  for (std::size_t k = 21; k < path.size(); ++k) {
    path[k].translation.x() += 5.0;
  }
  std::vector<Keyframe> keyframes = every_frame(path, 10.0);
  EXPECT_TRUE(find_revisits(keyframes, path).back().empty());
  for (std::size_t k = 21; k < path.size(); ++k) {
    keyframes[k].variance_m2 = 1.5 * 1.5;
  }
  EXPECT_FALSE(find_revisits(keyframes, path).back().empty());
}

TEST(Revisits, AreNotWhereTheCameraLooksElsewhere) {
  std::vector<Se3> path = there_and_back(21, 1.0);
  for (std::size_t k = 21; k < path.size(); ++k) {
    path[k].rotation = so3_exp({0.0, 3.1, 0.0});
  }
  for (const auto& places : find_revisits(every_frame(path, 10.0), path)) {
    EXPECT_TRUE(places.empty());
  }
}

TEST(PoseInformation, IsThatOfTheResidualsByThePose) {
  constexpr double kSigma_px = 0.2;
  const Eigen::Vector3d p_m(1.0, -0.5, 8.0);
  const Matrix6d information = pose_information(kGeometry, std::vector<Eigen::Vector3d>{p_m}, kSigma_px);
  Eigen::Matrix<double, 3, 6> jacobian;
  for (int i = 0; i < 6; ++i) {
    constexpr double kStep = 1e-6;
    const Se3 moved = left_update(Se3{}, kStep * Vector6d::Unit(i));
    jacobian.col(i) = (kGeometry.project(moved * p_m) - kGeometry.project(p_m)) / kStep;
  }
  const Matrix6d expected = jacobian.transpose() * jacobian / (2.0 * kSigma_px * kSigma_px);
  EXPECT_LT((information - expected).norm(), 1e-4 * expected.norm());
}

TEST(Loop, BendsAPathThatTurnsTooLittle) {
  constexpr std::size_t kFrames = 100;
  std::vector<Se3> truth{Se3{}};
  std::vector<Se3> path{Se3{}};
  for (std::size_t k = 1; k < kFrames; ++k) {
    truth.push_back(truth.back() * Se3{so3_exp({0.0, 2.0 * M_PI / (kFrames - 1), 0.0}), {0.0, 0.0, 0.5}});
    path.push_back(path.back() * Se3{so3_exp({0.0, 1.98 * M_PI / (kFrames - 1), 0.0}), {0.0, 0.0, 0.505}});
  }
  const double gap_m = (path.back().translation - truth.back().translation).norm();
  ASSERT_GT(gap_m, 0.2);
  Vector6d weights;
  weights << Eigen::Vector3d::Constant(1e6), Eigen::Vector3d::Constant(1e4);
  const Matrix6d information = weights.asDiagonal();
  const PathGraph graph{path,
                        std::vector<Matrix6d>(kFrames, information),
                        {{0, kFrames - 1, truth[0].inverse() * truth.back(), information}}};
  const auto bent = bend_path(kGeometry, graph, {}, kOptions);
  ASSERT_TRUE(bent) << bent.error().message;
  path = bent->T_world_cam;
  EXPECT_EQ(path.front().translation, Eigen::Vector3d::Zero());
  EXPECT_LT((path.back().translation - truth.back().translation).norm(), 0.05 * gap_m);
  // The correction is spread over all steps: none exceeds a few times the mean.
  for (std::size_t k = 1; k < kFrames; ++k) {
    EXPECT_LT(so3_log((path[k - 1].inverse() * path[k]).rotation).norm(), 2.1 * M_PI / (kFrames - 1)) << k;
  }
}

/// A wall with a pattern, 8 m in front of the first camera and slanted.
class SlantedWall {
 public:
  explicit SlantedWall(unsigned seed) : pattern_(1200, 2000, CV_8U) {
    cv::RNG random(seed);
    random.fill(pattern_, cv::RNG::UNIFORM, 20, 235);
    cv::GaussianBlur(pattern_, pattern_, {}, 2.5);
    cv::normalize(pattern_, pattern_, 10, 245, cv::NORM_MINMAX);
  }

  /// The wall as seen by a camera with this centre and these axes.
  [[nodiscard]] cv::Mat seen_from(const Se3& T_world_cam) const {
    const Eigen::Matrix3d K{
        {kGeometry.fx_px, 0.0, kGeometry.cx_px}, {0.0, kGeometry.fy_px, kGeometry.cy_px}, {0, 0, 1}};
    const Se3 T_cam_world = T_world_cam.inverse();
    Eigen::Matrix3d wall;  // Image of the wall's axes and origin.
    wall << T_cam_world.rotation * axis(0), T_cam_world.rotation * axis(1), T_cam_world * origin();
    const Eigen::Matrix3d image_of_wall = K * wall;
    cv::Matx33d warp;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        warp(r, c) = image_of_wall(r, c);
      }
    }
    cv::Mat image;
    cv::warpPerspective(pattern_, image, warp, {kGeometry.width_px, kGeometry.height_px}, cv::INTER_LINEAR,
                        cv::BORDER_REFLECT);
    return image;
  }
  /// Intersection of a pixel's ray with the wall, in the camera's frame.
  [[nodiscard]] static Eigen::Vector3d hit(const Se3& T_world_cam, double u_px, double v_px) {
    const Eigen::Vector3d ray((u_px - kGeometry.cx_px) / kGeometry.fx_px, (v_px - kGeometry.cy_px) / kGeometry.fy_px,
                              1.0);
    const Se3 T_cam_world = T_world_cam.inverse();
    const Eigen::Vector3d normal = T_cam_world.rotation * axis(0).cross(axis(1));
    return ray * normal.dot(T_cam_world * origin()) / normal.dot(ray);
  }

 private:
  static Eigen::Vector3d axis(int which) {
    constexpr double kPixel_m = 0.01;
    return kPixel_m * (which == 0 ? Eigen::Vector3d(std::cos(0.4), 0.0, std::sin(0.4)) : Eigen::Vector3d::UnitY());
  }
  static Eigen::Vector3d origin() { return Eigen::Vector3d(0.0, 0.0, 8.0) - 1000.0 * axis(0) - 600.0 * axis(1); }

  cv::Mat pattern_;
};

class PlaceMatcherTest : public ::testing::Test {
 protected:
  PlaceMatcherTest() {
    run_.rectified = kGeometry;
    run_.camera = {{0, 0, {}}, {1, 1, {}}};
    const Se3 T_now{so3_exp({0.02, -0.05, 0.01}), {0.3, -0.1, 0.6}};
    path_ = {Se3{}, T_now};
    for (std::size_t k = 0; k < path_.size(); ++k) {
      keyframes_.push_back({.row = k, .depth_m = 8.0});
    }
    for (float v = 25.0F; v < 215.0F; v += 12.0F) {
      for (float u = 60.0F; u < 600.0F; u += 22.0F) {
        const Eigen::Vector3d px = kGeometry.project(SlantedWall::hit({}, u, v));
        keyframes_[0].points.push_back(
            {0, static_cast<std::uint32_t>(keyframes_[0].points.size() + 1), px.cast<float>()});
      }
    }
    keyframes_[1].points = keyframes_[0].points;
  }

  /// `walls`: the wall of each frame.
  Result<std::optional<Loop>> match(const std::vector<const SlantedWall*>& walls, const std::vector<Se3>& poses) {
    const auto read = [&](std::int64_t frame) -> Result<RectifiedPair> {
      const auto k = static_cast<std::size_t>(frame);
      const Se3 right = path_[k] * Se3{Eigen::Matrix3d::Identity(), {kGeometry.baseline_m, 0.0, 0.0}};
      left_ = walls[k]->seen_from(path_[k]);
      right_ = walls[k]->seen_from(right);
      return RectifiedPair{frame, 0, {}, view(left_), view(right_), kGeometry};
    };
    const std::vector<std::size_t> candidates{0};
    return PlaceMatcher(run_, poses, read, kOptions).match(keyframes_, 1, candidates);
  }
  static GrayView view(const cv::Mat& image) {
    return {image.data, image.cols, image.rows, static_cast<int>(image.step)};
  }

  recording::Run run_;
  std::vector<Se3> path_;
  std::vector<Keyframe> keyframes_;
  cv::Mat left_, right_;
};

TEST_F(PlaceMatcherTest, FindsThePoseBetweenTwoViewsOfAPlace) {
  const SlantedWall wall(7);
  const auto loop = match({&wall, &wall}, path_);
  ASSERT_TRUE(loop) << loop.error().message;
  ASSERT_TRUE(*loop);
  const Vector6d error = left_difference((*loop)->T_from_to, path_[1]);
  EXPECT_LT(error.head<3>().norm(), 0.0005);
  EXPECT_LT(error.tail<3>().norm(), 0.005);
  EXPECT_LT(error.dot((*loop)->information * error), 100.0);
}

TEST_F(PlaceMatcherTest, FindsNothingWhereAnotherPlaceIsSeen) {
  const SlantedWall wall(7);
  const SlantedWall other(8);
  const auto loop = match({&wall, &other}, path_);
  ASSERT_TRUE(loop) << loop.error().message;
  EXPECT_FALSE(*loop);
}

TEST_F(PlaceMatcherTest, RejectsLoopsThatThePathContradicts) {
  const SlantedWall wall(7);
  std::vector<Se3> far_away = path_;
  far_away[1].translation.x() += 3.0;
  const auto loop = match({&wall, &wall}, far_away);
  ASSERT_TRUE(loop) << loop.error().message;
  EXPECT_FALSE(*loop);
}

}  // namespace
}  // namespace kinetrace::batch
