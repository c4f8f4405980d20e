// Costs of expected motion: derivatives against differences, and their effect in a batch problem.
#include "motion_costs.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

namespace kinetrace::refinement {
namespace {

Se3 pose(double turn, double way) {
  return {so3_exp({0.3 + turn, -0.2, 0.1 * turn}), {way, 0.5 - 0.2 * way, 4.0 + 0.1 * way}};
}

/// Largest difference between the derivatives of a cost and differences of its residuals.
template <int kRows = 6>
double derivative_error(const ceres::CostFunction& cost, std::vector<PoseBlock> blocks) {
  using Residual = Eigen::Matrix<double, kRows, 1>;
  constexpr double kStep = 1e-6;
  const std::size_t count = blocks.size();
  std::vector<double*> pointers;
  std::vector<PoseDerivative<kRows>> derivatives(count);
  std::vector<double*> derivative_pointers;
  for (std::size_t i = 0; i < count; ++i) {
    pointers.push_back(blocks[i].data());
    derivative_pointers.push_back(derivatives[i].data());
  }
  Residual at;
  EXPECT_TRUE(cost.Evaluate(pointers.data(), at.data(), derivative_pointers.data()));
  double largest = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const PoseBlock before = blocks[i];
    for (int k = 0; k < kPoseTangent; ++k) {
      Vector6d step = Vector6d::Zero();
      step[k] = kStep;
      Residual ahead;
      Residual behind;
      from_pose(left_update(to_pose(before.data()), step), blocks[i].data());
      EXPECT_TRUE(cost.Evaluate(pointers.data(), ahead.data(), nullptr));
      from_pose(left_update(to_pose(before.data()), -step), blocks[i].data());
      EXPECT_TRUE(cost.Evaluate(pointers.data(), behind.data(), nullptr));
      blocks[i] = before;
      largest = std::max(largest, ((ahead - behind) / (2.0 * kStep) - derivatives[i].col(k)).cwiseAbs().maxCoeff());
    }
  }
  return largest;
}

std::vector<PoseBlock> blocks_of(std::initializer_list<Se3> poses) {
  std::vector<PoseBlock> blocks;
  for (const Se3& each : poses) {
    from_pose(each, blocks.emplace_back().data());
  }
  return blocks;
}

const WorldPose kAt{{so3_exp({0.1, 0.7, -0.3}), {30.0, -2.0, 80.0}}};

// Derivatives assume small turns within an interval: hence the tolerances.
TEST(SteadyCost, HasTheDerivativesOfItsResiduals) {
  const SteadyCost cost({kAt, kAt, kAt}, 0.1, 0.15,
                        MotionPrior{90.0, 60.0, 100.0, 70.0}.root_information(Eigen::Vector3d(0.6, 0.8, 0.0),
                                                                              Eigen::Matrix3d::Identity(), 0.12));
  EXPECT_LT(derivative_error(cost, blocks_of({pose(0.0, 1.0), pose(0.002, 1.2), pose(0.003, 1.5)})), 0.01);
}

TEST(VelocityCost, HasTheDerivativesOfItsResiduals) {
  const VelocityCost cost({kAt, kAt}, 0.1, Vector6d::Constant(0.1));
  EXPECT_LT(derivative_error(cost, blocks_of({pose(0.0, 1.0), pose(0.002, 1.01)})), 0.01);
}

TEST(PoseCost, HasTheDerivativesOfItsResiduals) {
  const PoseCost cost(kAt, kAt.T_world_cam * pose(0.001, 1.1), Vector6d::Constant(2.0));
  EXPECT_LT(derivative_error(cost, blocks_of({pose(0.0, 1.0)})), 0.01);
}

/// A step with the scale fixed to 1.01.
class LongerStepCost final : public ceres::SizedCostFunction<6, kPoseAmbient, kPoseAmbient> {
 public:
  explicit LongerStepCost(const BatchStep& step) : cost_(step) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::array<const double*, 3> all{blocks[0], blocks[1], &scale_};
    std::array<double*, 3> derivatives{};
    if (jacobians != nullptr) {
      derivatives = {jacobians[0], jacobians[1], nullptr};
    }
    return cost_.Evaluate(all.data(), residuals, jacobians != nullptr ? derivatives.data() : nullptr);
  }

 private:
  StepCost cost_;
  double scale_ = 1.01;
};

BatchStep step_between(const Se3& a, const Se3& b) {
  BatchStep step{0, 1, a * b.inverse(), 2.0 * Matrix6d::Identity()};
  step.root_information(0, 4) = 0.5;
  step.T_from_to = left_update(step.T_from_to, Vector6d::Constant(1e-3));
  return step;
}

TEST(StepCost, HasTheDerivativesOfItsResiduals) {
  const Se3 a = pose(0.0, 1.0);
  const Se3 b = pose(0.1, 1.02);
  EXPECT_LT(derivative_error(LongerStepCost(step_between(a, b)), blocks_of({a, b})), 0.02);
}

TEST(StepCost, HasTheDerivativeByTheScale) {
  const std::vector<PoseBlock> poses = blocks_of({pose(0.0, 1.0), pose(0.1, 1.5)});
  const StepCost cost(step_between(pose(0.0, 1.0), pose(0.1, 1.5)));
  const auto at = [&](double scale, double* derivative) {
    const std::array<const double*, 3> blocks{poses[0].data(), poses[1].data(), &scale};
    std::array<double*, 3> derivatives{nullptr, nullptr, derivative};
    Vector6d residual;
    EXPECT_TRUE(cost.Evaluate(blocks.data(), residual.data(), derivatives.data()));
    return residual;
  };
  Vector6d derivative;
  at(1.0, derivative.data());
  EXPECT_LT(((at(1.001, nullptr) - at(0.999, nullptr)) / 0.002 - derivative).norm(), 1e-3);
}

TEST(FixCost, HasTheDerivativesOfItsResiduals) {
  const BatchFix fix{0, 1, 2, 0.3, {0.2, -1.1, -0.4}, {30.0, 40.0, 2.0}, {0.5, 0.7, 0.2}};
  EXPECT_LT(derivative_error<3>(FixCost(fix), blocks_of({pose(0.4, 2.0), pose(0.0, 1.0), pose(0.1, 1.5)})), 1e-4);
}

// A camera at rest sees an object pass in the first and the last three of nine frames.
class BatchMotionTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kFrames = 9;
  static constexpr double kSpeed_mps = 8.0;

  [[nodiscard]] static Se3 truth(std::size_t frame) {
    return {so3_exp({0.0, 0.02 * static_cast<double>(frame), 0.0}),
            {-3.0 + 0.1 * kSpeed_mps * static_cast<double>(frame), 0.0, 12.0}};
  }
  void measure(std::size_t frame) {
    measured_.push_back({static_cast<std::uint32_t>(frame), truth(frame), Vector6d::Constant(1e3)});
  }
  Result<BundleSummary> solve(double turn_rate_radps = std::numeric_limits<double>::infinity()) {
    for (std::size_t k = 0; k < kFrames; ++k) {
      T_body_cam_[k] = truth(0).inverse();
      times_[k] = static_cast<std::int64_t>(k) * 100'000'000;
    }
    BatchProblem problem{.geometry = {721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375},
                         .T_body_cam = T_body_cam_,
                         .fixed_frames = {},
                         .points_m = {},
                         .observations = {},
                         .motion = BatchMotion{.T_world_cam = T_world_cam_,
                                               .timestamps_ns = times_,
                                               .at_rest = at_rest_,
                                               .prior = prior_,
                                               .turn_rate_radps = turn_rate_radps},
                         .measured_poses = measured_};
    return CeresBundleAdjuster::create({})->refine_batch(problem);
  }

  std::vector<Se3> T_world_cam_ = std::vector<Se3>(kFrames);
  std::vector<Se3> T_body_cam_ = std::vector<Se3>(kFrames);
  std::vector<std::int64_t> times_ = std::vector<std::int64_t>(kFrames);
  std::vector<std::uint8_t> at_rest_ = std::vector<std::uint8_t>(kFrames);
  std::vector<BatchPose> measured_;
  MotionPrior prior_{1.0, 1.0, 1.0, 1.0};
};

TEST_F(BatchMotionTest, FillsFramesInWhichNothingIsMeasured) {
  for (const std::size_t frame : {0, 1, 2, 6, 7, 8}) {
    measure(frame);
  }
  const auto solved = solve();
  ASSERT_TRUE(solved) << solved.error().message;
  for (std::size_t k = 0; k < kFrames; ++k) {
    EXPECT_LT(left_difference(truth(k), T_body_cam_[k].inverse()).norm(), 2e-3) << k;
  }
}

TEST_F(BatchMotionTest, RestGivesWayToWhatMoves) {
  for (std::size_t k = 0; k < kFrames; ++k) {
    measure(k);
    at_rest_[k] = 1;
  }
  ASSERT_TRUE(solve());
  EXPECT_NEAR(T_body_cam_[8].inverse().translation.x(), truth(8).translation.x(), 0.01);
}

TEST_F(BatchMotionTest, TurnsFasterThanUsualOnlyAsFarAsThatIsMeasured) {
  const auto turned_rad = [&] { return so3_log(T_body_cam_[0].rotation * T_body_cam_[8].rotation.transpose()).norm(); };
  prior_ = {100.0, 100.0, 100.0, 100.0};  // The path does not follow the turns.
  for (std::size_t k = 0; k < kFrames; ++k) {
    measure(k);
  }
  ASSERT_TRUE(solve(0.02));
  EXPECT_NEAR(turned_rad(), 0.16, 0.001) << "ten times as fast as usual, and surely so";
  for (BatchPose& pose : measured_) {
    pose.inverse_sigma.setConstant(6.0);  // A sixth of a radian and of a metre.
  }
  ASSERT_TRUE(solve());
  EXPECT_NEAR(turned_rad(), 0.16, 0.01);
  ASSERT_TRUE(solve(0.02));
  EXPECT_LT(turned_rad(), 0.04) << "that may as well be noise";
}

TEST_F(BatchMotionTest, RefusesTimesThatStandStill) {
  measure(0);
  ASSERT_TRUE(solve());
  BatchProblem problem{.geometry = {721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375},
                       .T_body_cam = T_body_cam_,
                       .fixed_frames = {},
                       .points_m = {},
                       .observations = {},
                       .motion = BatchMotion{T_world_cam_, times_, at_rest_},
                       .measured_poses = measured_};
  times_[4] = times_[3];
  const auto refused = CeresBundleAdjuster::create({})->refine_batch(problem);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace kinetrace::refinement
