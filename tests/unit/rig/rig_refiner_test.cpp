#include "kinetrace/rig/rig_refiner.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "turned_rig.hpp"

namespace kinetrace::rig {
namespace {

using test::kDegree_rad;
using test::see;
using test::StreetOfPoints;
using test::turned;

constexpr std::size_t kPoints = 300;

/// A rig driven past static points. Points left behind restart ahead, as features do.
class Drive {
 public:
  explicit Drive(const RefineConfig& config)
      : arena_(RigRefiner::required_bytes(config) + Arena::kAlignment), refiner_(create(config)) {
    for (std::size_t i = 0; i < kPoints; ++i) {
      renew(i);
    }
  }

  [[nodiscard]] RigRefiner& refiner() { return refiner_; }

  /// One frame of a rig with the true correction `rig`, after a step of `step_m`, looking `heading_rad` to the right.
  void frame(const RigCorrection& rig, double step_m, double heading_rad = 0.0) {
    time_ns_ += 100'000'000;
    z_m_ += step_m;
    refiner_.begin_frame(time_ns_);
    const StereoGeometry g = test::street_rig();
    const RigChange corrected(g, {}, refiner_.correction());
    const Se3 T_world_cam{so3_exp({0.0, heading_rad, 0.0}), {0.0, 0.0, z_m_}};
    std::vector<RigObservation> seen;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d p = T_world_cam.inverse() * points_[i];
      if (p.z() < 4.0) {
        renew(i);
        continue;
      }
      const test::SeenByBoth both = see(g, rig, p);
      // As in the corrected image.
      const Eigen::Vector2d right =
          corrected.right_px(both.right_px, both.left_px.x() - both.right_px.x()) + errors_px_[i];
      const Eigen::Vector2d left = both.left_px + Eigen::Vector2d(street_.noise(0.05), street_.noise(0.05));
      seen.push_back({ids_[i], static_cast<std::uint16_t>(i), left.cast<float>(), right.cast<float>()});
    }
    refiner_.observe(seen, T_world_cam);
  }

 private:
  [[nodiscard]] RigRefiner create(const RefineConfig& config) {
    return RigRefiner::create(config, test::street_rig(), arena_).value();
  }
  void renew(std::size_t i) {
    points_[i] = street_.point() + Eigen::Vector3d(0.0, 0.0, z_m_);
    errors_px_[i] = {street_.noise(0.1), street_.noise(0.1)};
    ids_[i] = next_id_++;
  }

  Arena arena_;
  StreetOfPoints street_{5};
  std::vector<Eigen::Vector3d> points_ = std::vector<Eigen::Vector3d>(kPoints);
  std::vector<Eigen::Vector2d> errors_px_ = std::vector<Eigen::Vector2d>(kPoints);
  std::vector<std::uint32_t> ids_ = std::vector<std::uint32_t>(kPoints);
  std::uint32_t next_id_ = 1;
  std::int64_t time_ns_ = 0;
  double z_m_ = 0.0;
  RigRefiner refiner_;
};

TEST(RigRefiner, ATrueCalibrationStaysAsItIs) {
  Drive drive({});
  for (int i = 0; i < 100; ++i) {
    drive.frame({}, 0.7);
    EXPECT_TRUE(drive.refiner().correction().is_zero()) << i;
    EXPECT_FALSE(drive.refiner().revision()) << i;
  }
  EXPECT_EQ(drive.refiner().estimate().verdict, RigVerdict::kHolds);
  EXPECT_GT(drive.refiner().estimate().windows, 10U);
}

TEST(RigRefiner, AWrongOneIsCorrectedWithinASecond) {
  Drive drive({});
  const RigCorrection rig = turned(0.2, 0.3, -0.2);
  for (int i = 0; i < 10; ++i) {
    drive.frame(rig, 0.7);
  }
  EXPECT_EQ(drive.refiner().estimate().verdict, RigVerdict::kCorrected);
  for (int i = 0; i < 40; ++i) {
    drive.frame(rig, 0.7);
  }
  const RigCorrection::Vector error = drive.refiner().correction().vector() - rig.vector();
  EXPECT_LT(std::abs(error[0]), 0.005 * kDegree_rad);
  EXPECT_LT(std::abs(error[1] + error[5]) * test::street_rig().fx_px, 0.05);
  EXPECT_LT(std::abs(error[2]), 0.005 * kDegree_rad);
}

TEST(RigRefiner, ARevisionLeadsFromOneCorrectionToTheNext) {
  Drive drive({});
  RigCorrection last;
  bool must_restart = false;
  for (int i = 0; i < 12; ++i) {
    drive.frame(turned(0.0, 0.3, 0.0), 0.7);
    if (const auto revision = drive.refiner().revision()) {
      EXPECT_EQ(revision->before.vector(), last.vector());
      must_restart = must_restart || drive.refiner().must_restart();
    }
    last = drive.refiner().correction();
  }
  EXPECT_TRUE(must_restart) << "3.8 px are more than a window of bundle adjustment can bear";
  EXPECT_FALSE(last.is_zero());
}

TEST(RigRefiner, CheckingCorrectsNothing) {
  Drive drive({.mode = RefineMode::kCheck});
  for (int i = 0; i < 30; ++i) {
    drive.frame(turned(0.1, 0.2, 0.0), 0.7);
    EXPECT_TRUE(drive.refiner().correction().is_zero());
  }
  EXPECT_EQ(drive.refiner().estimate().verdict, RigVerdict::kOff);
  EXPECT_NEAR(drive.refiner().estimate().correction.turn_rad.x(), 0.1 * kDegree_rad, 0.005 * kDegree_rad);
}

TEST(RigRefiner, AtRestNothingIsConcluded) {
  Drive drive({});
  for (int i = 0; i < 60; ++i) {
    drive.frame(turned(0.1, 0.2, 0.0), 0.0);
    EXPECT_TRUE(drive.refiner().correction().is_zero());
  }
  EXPECT_EQ(drive.refiner().estimate().verdict, RigVerdict::kUnknown);
  EXPECT_EQ(drive.refiner().estimate().windows, 0U);
}

TEST(RigRefiner, AKnockIsFoundAndCorrectedWithinTwoSeconds) {
  Drive drive({});
  for (int i = 0; i < 40; ++i) {
    drive.frame({}, 0.7);
  }
  const RigCorrection knocked = turned(0.4, 0.5, -0.4);
  for (int i = 0; i < 20; ++i) {
    drive.frame(knocked, 0.7);
  }
  EXPECT_EQ(drive.refiner().estimate().knocks, 1U);
  const RigCorrection::Vector error = drive.refiner().correction().vector() - knocked.vector();
  EXPECT_LT(std::abs(error[1] + error[5]) * test::street_rig().fx_px, 0.15);
}

TEST(RigRefiner, AHeadThatTurnsShowsTheFocalLength) {
  Drive drive({});
  for (int i = 0; i < 150; ++i) {
    drive.frame(turned(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02), 0.4, 0.3 * std::sin(0.5 * i));
    EXPECT_EQ(drive.refiner().correction().focal, 0.0) << "the world would be stretched while it is mapped";
  }
  const RigEstimate& found = drive.refiner().estimate();
  EXPECT_TRUE(found.is_focal_known());
  EXPECT_NEAR(found.correction.focal, 0.02, 3.0 * found.sigma_rad[RigCorrection::kFocal]);
  EXPECT_GT(found.known_focal, 0.01);
  EXPECT_EQ(found.verdict, RigVerdict::kOff);
}

TEST(RigRefiner, StraightAheadNothingIsSaidOfTheFocalLength) {
  Drive drive({});
  for (int i = 0; i < 100; ++i) {
    drive.frame(turned(0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.02), 0.7);
  }
  EXPECT_FALSE(drive.refiner().estimate().is_focal_known());
  EXPECT_EQ(drive.refiner().estimate().known_focal, 0.0);
  EXPECT_EQ(drive.refiner().estimate().verdict, RigVerdict::kCorrected);
}

TEST(RigRefiner, TheSameFramesGiveTheSameBits) {
  Drive a({});
  Drive b({});
  for (int i = 0; i < 30; ++i) {
    a.frame(turned(0.0, 0.1, 0.0), 0.7);
    b.frame(turned(0.0, 0.1, 0.0), 0.7);
    EXPECT_EQ(a.refiner().correction().vector(), b.refiner().correction().vector());
  }
}

TEST(RigRefiner, AnArenaTooSmallIsRefusedWithTheRemedy) {
  Arena arena(1024);
  const auto refiner = RigRefiner::create({}, test::street_rig(), arena);
  ASSERT_FALSE(refiner);
  EXPECT_EQ(refiner.error().code, ErrorCode::kCapacity);
  EXPECT_NE(refiner.error().message.find("calibration.refine"), std::string::npos);
  EXPECT_EQ(RigRefiner::required_bytes({.mode = RefineMode::kOff}), 0U);
  EXPECT_LT(RigRefiner::required_bytes({}), 200U * 1024U);
}

}  // namespace
}  // namespace kinetrace::rig
