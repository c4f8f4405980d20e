#include "measurement/background_measurement.hpp"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "run_observations.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::batch {
namespace {

using recording::Observation;

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 200;
constexpr int kFrames = 6;
constexpr double kDisparity_px = 12.3;
constexpr double kStep_px = 2.7;  // Motion of the wall from frame to frame.
constexpr StereoGeometry kGeometry{.fx_px = 300.0,
                                   .fy_px = 300.0,
                                   .cx_px = 159.5,
                                   .cy_px = 99.5,
                                   .baseline_m = 0.2,
                                   .width_px = kWidth_px,
                                   .height_px = kHeight_px};

/// A wall that never repeats itself.
double gray(const Eigen::Vector2d& at_px) {
  return 128.0 + 35.0 * std::sin(0.45 * at_px.x() + 0.21 * at_px.y()) +
         30.0 * std::sin(0.37 * at_px.y() - 0.16 * at_px.x() + 1.0) + 20.0 * std::sin(0.083 * at_px.x() + 0.3);
}

template <typename FromPixel>
std::vector<std::uint8_t> picture(const FromPixel& on_wall_px) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kHeight_px; ++y) {
    for (int x = 0; x < kWidth_px; ++x) {
      pixels.push_back(static_cast<std::uint8_t>(std::lround(gray(on_wall_px(Eigen::Vector2d(x, y))))));
    }
  }
  return pixels;
}

class BackgroundMeasurement : public ::testing::Test {
 protected:
  void SetUp() override {
    run_.directory = folder_.path();
    run_.is_finished = false;
    run_.rectified = kGeometry;
    std::ofstream file(folder_.path() / "observations.bin", std::ios::binary);
    file << "kinetrace observations\n1";
    for (int frame = 0; frame < kFrames; ++frame) {
      for (std::uint32_t id = 1; id <= 12; ++id) {
        write(file, as_recorded(0, id, frame));
      }
      write(file, as_recorded(7, 1, frame));
    }
  }

  static Eigen::Vector2d true_left_px(std::uint32_t id, int frame) {
    const std::uint32_t row = (id - 1U) / 4U;
    return {60.25 + 40.0 * (id - 1U - 4U * row) + kStep_px * frame, 50.5 + 45.0 * row};
  }
  /// An observation with an error of up to .3 px that changes in every frame.
  static Observation as_recorded(std::uint32_t track_id, std::uint32_t id, int frame) {
    const Eigen::Vector2d left_px = true_left_px(id, frame);
    const auto off_px = [&](double phase) { return 0.3 * std::sin(2.3 * id + 1.9 * frame + phase); };
    return {.track_id = track_id,
            .point_id = id,
            .frame = frame,
            .u_left_px = static_cast<float>(left_px.x() + off_px(0.0)),
            .v_px = static_cast<float>(left_px.y() + off_px(1.0)),
            .u_right_px = static_cast<float>(left_px.x() - kDisparity_px + off_px(2.0))};
  }
  static void write(std::ofstream& file, const Observation& seen) {
    file.write(reinterpret_cast<const char*>(&seen),
               sizeof seen);  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
  }

  /// The wall as both cameras see it, the right one mounted by `run_.applied`.
  Result<RectifiedPair> pair(std::int64_t frame) {
    if (frame == unreadable_frame_) {
      return fail(ErrorCode::kIo, "no such picture");
    }
    const Eigen::Vector2d moved_px(kStep_px * static_cast<double>(frame), 0.0);
    left_ = picture([&](const Eigen::Vector2d& px) -> Eigen::Vector2d {
      const bool is_covered = frame >= covered_from_ && px.x() < 90.0;
      return px - moved_px + (is_covered ? Eigen::Vector2d(217.0, 331.0) : Eigen::Vector2d::Zero());
    });
    const RigChange corrected(kGeometry, RigCorrection{}, run_.applied);
    right_ = picture([&](const Eigen::Vector2d& px) -> Eigen::Vector2d {
      return corrected.right_px(px, kDisparity_px) + Eigen::Vector2d(kDisparity_px, 0.0) - moved_px;
    });
    RectifiedPair pair;
    pair.frame_index = frame;
    pair.left = {left_.data(), kWidth_px, kHeight_px, kWidth_px};
    pair.right = {right_.data(), kWidth_px, kHeight_px, kWidth_px};
    pair.geometry = kGeometry;
    return pair;
  }

  MeasuredBackground measured() {
    auto result = measure_background(run_, [this](std::int64_t frame) { return pair(frame); },
                                     {[] { return true; }, [](std::size_t) {}});
    EXPECT_TRUE(result) << result.error().message;
    return std::move(*result);
  }
  /// Largest distance of points from their first observation, corrected for the wall's motion.
  static double largest_error_px(const MeasuredBackground& measured) {
    std::map<std::uint32_t, Eigen::Vector2d> first_off_px;
    double largest_px = 0.0;
    for (int frame = 0; frame < kFrames; ++frame) {
      for (const Observation& seen : measured.frames.at(frame)) {
        const Eigen::Vector2d off_px = Eigen::Vector2d(seen.u_left_px, seen.v_px) - true_left_px(seen.point_id, frame);
        first_off_px.emplace(seen.point_id, off_px);
        largest_px = std::max({largest_px, (off_px - first_off_px.at(seen.point_id)).norm(),
                               std::abs(double{seen.u_left_px} - seen.u_right_px - kDisparity_px)});
      }
    }
    return largest_px;
  }

  recording::TemporaryFolder folder_;
  recording::Run run_;
  std::int64_t unreadable_frame_ = -1;
  std::int64_t covered_from_ = kFrames;
  std::vector<std::uint8_t> left_, right_;
};

TEST_F(BackgroundMeasurement, FindsTheSamePartOfTheSurfaceInAllPictures) {
  const MeasuredBackground result = measured();
  ASSERT_EQ(result.frames.size(), std::size_t{kFrames});
  EXPECT_LT(largest_error_px(result), 0.02);
  EXPECT_TRUE(result.part_of.empty());
}

TEST_F(BackgroundMeasurement, TakesTheRightCameraAsTheRunHasCorrectedIt) {
  run_.applied.turn_rad = {0.004, -0.003, 0.002};
  run_.applied.baseline_rad = {0.01, 0.0};
  EXPECT_LT(largest_error_px(measured()), 0.02);
}

TEST_F(BackgroundMeasurement, LeavesAFrameWithoutPicturesAsItIs) {
  unreadable_frame_ = 3;
  const MeasuredBackground result = measured();
  EXPECT_FALSE(result.frames.contains(3));
  EXPECT_EQ(result.part_of.size(), 12U) << "afterwards they are others";
  EXPECT_EQ(result.frames.at(4).front().point_id, result.frames.at(5).front().point_id);

  Result<RunObservations> observations = RunObservations::open(run_, result);
  ASSERT_TRUE(observations);
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto seen = observations->next_frame();
    ASSERT_TRUE(seen);
    ASSERT_EQ(seen->size(), 13U);
    // In the frame of its template, a point keeps the run's position.
    const bool is_as_recorded = frame == 0 || frame == 3 || frame == 4;
    EXPECT_EQ(seen->front().u_left_px == as_recorded(0, 1, frame).u_left_px, is_as_recorded) << frame;
    EXPECT_EQ(seen->back().track_id, 7U);
    EXPECT_EQ(seen->back().u_left_px, as_recorded(7, 1, frame).u_left_px) << "objects' points are not measured";
  }
  EXPECT_TRUE(observations->next_frame()->empty());
}

TEST_F(BackgroundMeasurement, BeginsAPointAnewThatLooksLikeSomethingElse) {
  covered_from_ = 2;
  const MeasuredBackground result = measured();
  EXPECT_EQ(result.frames.at(1)[0].point_id, 1U);
  const std::uint32_t part = result.frames.at(2)[0].point_id;
  EXPECT_GT(part, 12U);
  EXPECT_EQ(result.part_of.at(part), 1U);
  EXPECT_TRUE(std::isnan(result.frames.at(2)[0].u_right_px)) << "the right image shows what was there before";
  EXPECT_EQ(result.frames.at(2)[2].point_id, 3U) << "not covered";
}

}  // namespace
}  // namespace kinetrace::batch
