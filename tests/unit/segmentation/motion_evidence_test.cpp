#include "kinetrace/segmentation/motion_evidence.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr std::int64_t kIntervalNs = 100'000'000;

/// One feature that sees `p_cam`, with the previous observation filled in.
class OneFeature {
 public:
  explicit OneFeature(const StereoGeometry& geometry) : geometry_(geometry) { f_.id = 7; }
  Feature& see(const Eigen::Vector3d& p_cam) {
    const Eigen::Vector3d uvr = geometry_.project(p_cam);
    f_.age_frames = seen_++;
    f_.previous_left_px = f_.left_px;
    f_.previous_v_px = f_.v_px;
    f_.previous_u_right_px = f_.u_right_px;
    f_.left_px = uvr.head<2>().cast<float>();
    f_.v_px = f_.left_px.y();
    f_.u_right_px = static_cast<float>(uvr.z());
    return f_;
  }

 private:
  StereoGeometry geometry_;
  Feature f_;
  std::uint32_t seen_ = 0;
};

class MotionEvidenceTest : public ::testing::Test {
 protected:
  MotionEvidenceTest() : evidence_({}, geometry_, 1, arena_), feature_(geometry_) {}

  /// Frame `i` of a camera that drives along z at `ego_mps` and a point that starts at `p_m` and moves.
  FeatureMotion step(int i, double ego_mps, const Eigen::Vector3d& p_m, const Eigen::Vector3d& velocity_mps) {
    const Se3 T_world_cam = test::driven(0.1 * ego_mps * i);
    const Se3 T_prev_cam = test::driven(0.1 * ego_mps);
    Feature& f = feature_.see(T_world_cam.inverse() * (p_m + 0.1 * i * velocity_mps));
    return evidence_.update({&f, 1}, {}, T_prev_cam, i * kIntervalNs)[0];
  }

  StereoGeometry geometry_ = test::street_rig();
  Arena arena_{1U << 16U};
  MotionEvidence evidence_;
  OneFeature feature_;
};

TEST_F(MotionEvidenceTest, FindsTheVelocityFromTheThirdFrameOn) {
  const Eigen::Vector3d velocity(3.0, -0.5, -8.0);
  for (int i = 0; i < 12; ++i) {
    const FeatureMotion motion = step(i, 10.0, {2.0, 1.0, 30.0}, velocity);
    EXPECT_EQ(motion.known, i >= 2);
    EXPECT_EQ(motion.fresh, i == 1);
    if (motion.known) {
      const Eigen::Vector3f error = motion.velocity_mps - velocity.cast<float>();
      EXPECT_LT(error.dot(motion.information * error), 1.F) << i << ": off by " << error.transpose();
    }
    if (i == 11) {
      EXPECT_LT((motion.velocity_mps.cast<double>() - velocity).norm(), 0.1);
    }
    EXPECT_NEAR(evidence_.ego_speed_mps(), i == 0 ? 0.0 : 10.0, 1e-9);
  }
}

TEST_F(MotionEvidenceTest, IsSurerTheLongerItLooks) {
  float sigma_z = 1e9F;
  for (int i = 0; i < 8; ++i) {
    const FeatureMotion motion = step(i, 5.0, {2.0, 1.0, 30.0}, Eigen::Vector3d::Zero());
    if (motion.known) {
      EXPECT_LT(motion.covariance(2, 2), 0.8F * sigma_z);
      EXPECT_GT(motion.covariance(2, 2), 20.F * motion.covariance(1, 1)) << "depth is known less well than direction";
      sigma_z = motion.covariance(2, 2);
    }
  }
}

TEST_F(MotionEvidenceTest, UsesTheObservationBeforeItsFirstFrame) {
  // Found in frame 0 after segmentation, first shown in frame 1.
  feature_.see({2.0, 1.0, 20.0});
  Feature unused;
  evidence_.update({&unused, 0}, {}, {}, 0);
  FeatureMotion motion;
  for (int i = 1; i < 3; ++i) {
    Feature& f = feature_.see({2.0 + 0.3 * i, 1.0, 20.0});
    motion = evidence_.update({&f, 1}, {}, {}, i * kIntervalNs)[0];
  }
  EXPECT_TRUE(motion.known);
  EXPECT_NEAR(motion.velocity_mps.x(), 3.F, 0.01F);
}

TEST_F(MotionEvidenceTest, LeavesOneWrongObservationOut) {
  FeatureMotion motion;
  for (int i = 0; i < 8; ++i) {
    const Se3 T_world_cam = test::driven(0.5 * i);
    Feature f = feature_.see(T_world_cam.inverse() * Eigen::Vector3d(2.0, 1.0, 25.0));
    f.u_right_px += i == 4 ? 6.F : 0.F;
    motion = evidence_.update({&f, 1}, {}, test::driven(0.5), i * kIntervalNs)[0];
  }
  EXPECT_TRUE(motion.known);
  EXPECT_LT(motion.velocity_mps.norm(), 0.05F);
}

TEST_F(MotionEvidenceTest, HasNoSayAboutAFeatureThatJumpsAbout) {
  FeatureMotion motion;
  for (int i = 0; i < 8; ++i) {
    Feature f = feature_.see({2.0, 1.0, 25.0});
    f.left_px.x() += i % 2 == 0 ? 5.F : -5.F;
    motion = evidence_.update({&f, 1}, {}, {}, i * kIntervalNs)[0];
  }
  EXPECT_FALSE(motion.known);
}

TEST_F(MotionEvidenceTest, HasNoSayAboutFarOrUnmatchedFeatures) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(step(i, 5.0, {2.0, 1.0, 400.0}, Eigen::Vector3d::Zero()).known);
  }
  for (int i = 5; i < 10; ++i) {
    Feature f = feature_.see({2.0, 1.0, 25.0});
    f.u_right_px = kNoRight;
    EXPECT_FALSE(evidence_.update({&f, 1}, {}, {}, i * kIntervalNs)[0].known);
  }
}

TEST_F(MotionEvidenceTest, ForgetsAFeatureWhoseSlotWasReused) {
  for (int i = 0; i < 5; ++i) {
    step(i, 0.0, {2.0, 1.0, 20.0}, {5.0, 0.0, 0.0});
  }
  OneFeature other(geometry_);
  Feature f = other.see({-3.0, 1.0, 12.0});
  f.id = 8;
  EXPECT_FALSE(evidence_.update({&f, 1}, {}, {}, 5 * kIntervalNs)[0].known);
}

TEST_F(MotionEvidenceTest, KnowsHowSureItIs) {
  // Static features under Gaussian noise of the assumed size: velocity^T information velocity has three degrees of
  // freedom. The filter must not be overconfident; it is slightly underconfident, since its memory fades.
  test::WorldConfig world_config;
  world_config.sigma_px = MotionConfig{}.sigma_px;
  world_config.right_ratio = 1.0;
  test::SyntheticWorld world(world_config);
  Arena arena(std::size_t{8} << 20U);
  MotionEvidence evidence({}, world_config.geometry, world_config.capacity, arena);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 30; ++i) {
    const FeatureFrame frame = world.observe(test::driven(0.5 * i));
    for (const FeatureMotion& motion : evidence.update(frame.features, {}, test::driven(0.5), frame.timestamp_ns)) {
      sum += motion.known ? motion.static_chi2 : 0.F;
      count += motion.known ? 1 : 0;
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_LT(sum / count, 3.2);
  EXPECT_GT(sum / count, 1.5);
}

/// Vertical stripes every `period_px`, drawn so that the image is the same in every frame.
std::vector<std::uint8_t> stripes(const StereoGeometry& g, int period_px) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(g.width_px) * static_cast<std::size_t>(g.height_px));
  std::uint32_t state = 1;
  for (int y = 0; y < g.height_px; ++y) {
    for (int x = 0; x < g.width_px; ++x) {
      state = state * 1664525U + 1013904223U;
      const bool bright = period_px > 0 ? x % period_px < period_px / 2 : state >> 31U != 0;
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(g.width_px) + static_cast<std::size_t>(x)] =
          bright ? 200 : 60;
    }
  }
  return pixels;
}

TEST_F(MotionEvidenceTest, RejectsAFeatureThatTravelsWithTheCameraOverRepetitiveTexture) {
  // The camera moves sideways so that stripes at 20 m shift by exactly one period of 18 px a frame; a track that stays
  // in place in the image has jumped from stripe to stripe.
  const double step_m = 18.0 * 20.0 / geometry_.fx_px;
  for (const int period_px : {18, 0}) {
    evidence_.reset();
    const std::vector<std::uint8_t> pixels = stripes(geometry_, period_px);
    const GrayView left{pixels.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
    FeatureMotion motion;
    for (int i = 0; i < 5; ++i) {
      Feature& f = feature_.see({0.0, 1.0, 20.0});
      motion = evidence_.update({&f, 1}, left, {Eigen::Matrix3d::Identity(), {step_m, 0.0, 0.0}}, i * kIntervalNs)[0];
    }
    EXPECT_EQ(motion.known, period_px == 0);
  }
}

}  // namespace
}  // namespace kinetrace::segmentation
