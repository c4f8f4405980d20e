#include "trajectory_buffer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kFrames = 12;
constexpr std::uint32_t kTrack = 7;
constexpr double kStep_s = 0.1;
constexpr double kSpeed_mps = 8.0;

Matrix6d covariance(double sigma_rad, double sigma_m) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(sigma_rad * sigma_rad), Eigen::Vector3d::Constant(sigma_m * sigma_m);
  return variance.asDiagonal();
}

Se3 truth(std::size_t frame) {
  return {Eigen::Matrix3d::Identity(), {0.0, 0.0, kSpeed_mps * kStep_s * static_cast<double>(frame)}};
}

/// An object tracked at first by stereo alone, off the true path, whose reconstruction began with frame kBegins.
class TrajectoryBufferTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kBegins = 5;

  void tell(FrameChange change, const Eigen::Vector3d& astray_m) {
    for (std::size_t frame = 0; frame < kFrames; ++frame) {
      BufferedFrame& kept = ring_.push();
      kept.timestamp_ns = static_cast<std::int64_t>(frame) * 100'000'000;
      BufferedObject& entry = kept.objects[kept.object_count++];
      entry = {};
      entry.result.track_id = kTrack;
      entry.result.T_world_obj = truth(frame);
      entry.result.T_obj_cam = truth(frame).inverse();
      entry.result.covariance = covariance(0.01, 0.02);
      if (frame < kBegins) {
        entry.result.T_world_obj.translation += astray_m;
        entry.result.covariance = covariance(1.0, 1.0);
      }
      entry.change = frame == kBegins ? change : FrameChange::kNone;
    }
  }

  std::optional<PathEnd> smooth_all(std::size_t pending = kFrames) {
    std::optional<PathEnd> newest;
    for (std::size_t age = 0; age < pending; ++age) {
      if (TrajectoryBuffer::ends_at(ring_, kTrack, age)) {
        const std::optional<PathEnd> end = paths_.smooth(ring_, pending, kTrack, age, {});
        newest = age == 0 ? end : newest;
      }
    }
    return newest;
  }

  /// Error of the newest pose, frame by frame, of an object without a reconstruction. Its first positions are 3 m off.
  std::vector<double> errors_of_long_path(const PathObject& object) {
    constexpr std::size_t kPending = kFrames - 2;
    std::vector<double> errors_m;
    for (std::size_t frame = 0; frame < 60; ++frame) {
      if (ring_.full()) {
        ring_.pop_oldest();
      }
      BufferedFrame& kept = ring_.push();
      kept.timestamp_ns = static_cast<std::int64_t>(frame) * 100'000'000;
      BufferedObject& entry = kept.objects[kept.object_count++];
      entry = {};
      entry.result.track_id = kTrack;
      entry.result.status = BodyStatus::kStereoOnly;
      Se3 measured = truth(frame);
      measured.translation.z() += 3.0 * std::exp(-0.2 * static_cast<double>(frame));
      entry.result.T_obj_cam = measured.inverse();
      entry.result.covariance = covariance(1.0, 1.0);
      const std::size_t pending = std::min(kPending, ring_.size());
      for (std::size_t age = 0; age < pending; ++age) {
        ObjectResult& result = ring_.frame(age).find(kTrack)->result;
        result.T_world_obj = result.T_obj_cam.inverse();
      }
      paths_.smooth(ring_, pending, kTrack, 0, object);
      errors_m.push_back(
          (ring_.frame(0).find(kTrack)->result.T_world_obj.translation - truth(frame).translation).norm());
    }
    return errors_m;
  }

  const ObjectResult& reported(std::size_t frame) { return ring_.frame(kFrames - 1 - frame).find(kTrack)->result; }
  double off_m(std::size_t frame) {
    return (reported(frame).T_world_obj.translation - truth(frame).translation).norm();
  }

  Arena arena_{std::size_t{1} << 18};
  ResultRing ring_{arena_, kFrames, 2};
  TrajectoryBuffer paths_{trajectory::TrajectoryConfig{}, kFrames, arena_};
};

TEST_F(TrajectoryBufferTest, LeadsWhatStereoAloneSawToWhereTheReconstructionBegins) {
  tell(FrameChange::kRefined, {0.8, 0.0, -0.8});
  smooth_all();
  for (std::size_t frame = 0; frame < kBegins; ++frame) {
    EXPECT_LT(off_m(frame), 0.2) << frame;
  }
}

TEST_F(TrajectoryBufferTest, LeavesThePathOfAnotherPointAlone) {
  tell(FrameChange::kReplaced, {0.8, 0.0, -0.8});
  smooth_all();
  for (std::size_t frame = 0; frame < kBegins; ++frame) {
    EXPECT_GT(off_m(frame), 1.0) << frame;
  }
}

// But for the wide prior of the first velocity.
TEST_F(TrajectoryBufferTest, LearnsNothingFromBeforeTheReconstruction) {
  tell(FrameChange::kRefined, {3.0, 0.0, -30.0});
  const std::optional<PathEnd> end = smooth_all();
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->velocity.tail<3>().z(), kSpeed_mps, 1e-4);
  EXPECT_LT((end->T_world_obj.translation - truth(kFrames - 1).translation).norm(), 1e-4);
  EXPECT_LT(off_m(kBegins), 1e-4);
}

TEST_F(TrajectoryBufferTest, PosesWithoutAReconstructionCountAsTheFewThatAreIndependent) {
  const auto off_after = [&](BodyStatus at_first) {
    while (ring_.size() > 0) {
      ring_.pop_oldest();
    }
    tell(FrameChange::kNone, {0.4, 0.0, 0.0});
    for (std::size_t frame = 0; frame < kFrames; ++frame) {
      ObjectResult& result = ring_.frame(kFrames - 1 - frame).find(kTrack)->result;
      result.status = frame < kBegins ? at_first : BodyStatus::kTracked;
      result.covariance = frame < kBegins ? covariance(0.1, 0.2) : result.covariance;
    }
    smooth_all();
    return off_m(0);
  };
  EXPECT_LT(off_after(BodyStatus::kStereoOnly), 0.5 * off_after(BodyStatus::kTracked));
}

TEST_F(TrajectoryBufferTest, WithoutAReconstructionAPathForgetsTheErrorOfItsFirstPoses) {
  const std::vector<double> errors_m = errors_of_long_path({.reconstructed = false});
  for (std::size_t frame = 30; frame < errors_m.size(); ++frame) {
    EXPECT_LT(errors_m[frame], 0.3) << frame;
  }
}

TEST_F(TrajectoryBufferTest, ChangesNothingThatHasBeenPublished) {
  tell(FrameChange::kRefined, {0.8, 0.0, -0.8});
  smooth_all(kFrames - 2);
  EXPECT_GT(off_m(1), 1.0);
  EXPECT_LT(off_m(kBegins - 1), off_m(1));
}

}  // namespace
}  // namespace kinetrace::pipeline
