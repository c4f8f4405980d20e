#include "rig_filter.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turned_rig.hpp"

namespace kinetrace::rig {
namespace {

using test::kDegree_rad;
using test::turned;

constexpr double kWindow_s = 0.3;
constexpr double kSigma_rad = 0.003 * kDegree_rad;

class Measuring {
 public:
  RigMeasurement operator()(const RigCorrection& now, const RigCorrection& before, double scatter = 1.0) {
    RigMeasurement measured;
    measured.value << now.vector(), now.vector() - before.vector();
    for (double& value : measured.value) {
      value += scatter * kSigma_rad * std::normal_distribution<double>()(random_);
    }
    measured.covariance = RigMeasurement::Matrix::Identity() * (kSigma_rad * kSigma_rad);
    measured.points = 100;
    measured.valid = true;
    return measured;
  }

 private:
  std::mt19937 random_{7};
};

RigFilter fresh() {
  return RigFilter(RigCorrection::Vector::Constant(kDegree_rad));
}

void step(RigFilter& filter, const RigMeasurement& measured) {
  filter.predict(kWindow_s);
  filter.update(measured, kWindow_s);
}

TEST(RigFilter, ARigThatHoldsStillBecomesBetterKnownWithEveryWindow) {
  Measuring measure;
  RigFilter filter = fresh();
  const RigCorrection rig = turned(0.2, -0.1, 0.05);
  for (int i = 0; i < 30; ++i) {
    step(filter, measure(rig, rig));
  }
  EXPECT_TRUE(filter.holds_still());
  EXPECT_EQ(filter.knocks(), 0U);
  const double sigma_rad = std::sqrt(filter.covariance()(1, 1));
  EXPECT_LT(sigma_rad, 0.5 * kSigma_rad);
  EXPECT_LT((filter.correction() - rig.vector()).cwiseAbs().maxCoeff(), 4.0 * sigma_rad);
}

TEST(RigFilter, ARigThatDriftsIsFollowed) {
  Measuring measure;
  RigFilter filter = fresh();
  const auto rig = [](double time_s) { return turned(0.0, 0.1 * std::sin(0.7 * time_s), 0.0); };
  double worst_rad = 0.0;
  for (int i = 1; i <= 60; ++i) {
    step(filter, measure(rig(i * kWindow_s), rig((i - 1) * kWindow_s)));
    if (i > 10) {
      worst_rad = std::max(worst_rad, std::abs(filter.correction()[1] - rig(i * kWindow_s).turn_rad.y()));
    }
  }
  EXPECT_FALSE(filter.holds_still());
  EXPECT_EQ(filter.knocks(), 0U);
  EXPECT_LT(worst_rad, 4.0 * kSigma_rad);
}

TEST(RigFilter, AKnockIsTakenOnceTwoWindowsAgree) {
  Measuring measure;
  RigFilter filter = fresh();
  const RigCorrection before = turned(0.0, 0.0, 0.0);
  const RigCorrection after = turned(0.2, 0.3, -0.2);
  for (int i = 0; i < 12; ++i) {
    step(filter, measure(before, before));
  }
  step(filter, measure(after, after));
  EXPECT_EQ(filter.knocks(), 0U) << "one measurement may be wrong";
  EXPECT_LT(std::abs(filter.correction()[1]), 0.05 * kDegree_rad);
  step(filter, measure(after, after));
  EXPECT_EQ(filter.knocks(), 1U);
  EXPECT_NEAR(filter.correction()[1], after.turn_rad.y(), 5.0 * kSigma_rad);
}

TEST(RigFilter, AKnockLeavesTheFocalLength) {
  Measuring measure;
  RigFilter filter = fresh();
  const RigCorrection before = turned(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.01);
  for (int i = 0; i < 12; ++i) {
    step(filter, measure(before, before));
  }
  const double known = filter.correction()[RigCorrection::kFocal];
  // Not observable in the windows after the knock.
  const auto knocked = [&measure] {
    RigMeasurement measured = measure(turned(0.3, 0.3, -0.2), turned(0.3, 0.3, -0.2));
    measured.covariance(RigCorrection::kFocal, RigCorrection::kFocal) = 1.0;
    return measured;
  };
  step(filter, knocked());
  step(filter, knocked());
  EXPECT_EQ(filter.knocks(), 1U);
  EXPECT_NEAR(filter.correction()[RigCorrection::kFocal], known, 1e-5);
}

TEST(RigFilter, OneWrongMeasurementIsForgotten) {
  Measuring measure;
  RigFilter filter = fresh();
  const RigCorrection rig = turned(0.0, 0.02, 0.0);
  for (int i = 0; i < 12; ++i) {
    step(filter, measure(rig, rig));
  }
  step(filter, measure(turned(0.5, -0.5, 0.5), rig));
  for (int i = 0; i < 6; ++i) {
    step(filter, measure(rig, rig));
  }
  EXPECT_EQ(filter.knocks(), 0U);
  EXPECT_NEAR(filter.correction()[1], rig.turn_rad.y(), 4.0 * kSigma_rad);
}

TEST(RigFilter, MeasurementsThatScatterMoreThanTheySayCountForLess) {
  Measuring measure;
  RigFilter calm = fresh();
  RigFilter scattered = fresh();
  const RigCorrection rig = turned(0.1, 0.0, 0.0);
  for (int i = 0; i < 40; ++i) {
    step(calm, measure(rig, rig));
    step(scattered, measure(rig, rig, 3.0));
  }
  EXPECT_LT(calm.scatter(), 1.5);
  EXPECT_GT(scattered.scatter(), 2.5);
  EXPECT_GT(scattered.covariance()(0, 0), 2.0 * calm.covariance()(0, 0));
}

}  // namespace
}  // namespace kinetrace::rig
