#include "kinetrace/geo/alignment.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "normal_equations.hpp"
#include "receiver.hpp"

namespace kinetrace::geo {
namespace {

using test::any_placement;
using test::drive;
using test::receive;
using test::Receiver;

constexpr double kDegree = M_PI / 180.0;

/// Error of the alignment on the map: rotation (rad), position of the path's middle (m), time offset (s).
Eigen::Matrix<double, 7, 1> error_of(const Alignment& alignment, const Receiver& receiver) {
  const Se3& truth = receiver.T_map_world;
  const Eigen::Vector3d middle_world = alignment.T_map_world.inverse() * alignment.center_m;
  Eigen::Matrix<double, 7, 1> error;
  error << so3_log(truth.rotation * alignment.T_map_world.rotation.transpose()),
      truth * middle_world - alignment.center_m, receiver.time_offset_s - alignment.time_offset_s;
  return error;
}

/// Root mean square over the path.
double path_error_m(const Alignment& alignment, const Receiver& receiver, const std::vector<PathPose>& path) {
  double sum = 0.0;
  for (const PathPose& pose : path) {
    const Eigen::Vector3d& p = pose.T_world_cam.translation;
    sum += (alignment.T_map_world * p - receiver.T_map_world * p).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(path.size()));
}

Alignment align_or_fail(const std::vector<PathPose>& path, const std::vector<Fix>& fixes,
                        const AlignmentConfig& config) {
  const Result<Alignment> alignment = align(path, fixes, config);
  EXPECT_TRUE(alignment) << alignment.error().message;
  return alignment.value_or(Alignment{});
}

TEST(Alignment, FindsPlacementAndTimeOffsetOfAPerfectReference) {
  std::mt19937 random(1);
  const auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.3), .time_offset_s = 2.345, .noise_m = 0.0};
  auto fixes = receive(path, receiver, random);
  for (Fix& fix : fixes) {
    fix.sigma_m.setConstant(1.0);
  }
  const Alignment alignment = align_or_fail(path, fixes, {.path_drift = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kAligned) << alignment.reason;
  EXPECT_LT(path_error_m(alignment, receiver, path), 1e-4);
  EXPECT_NEAR(alignment.time_offset_s, 2.345, 1e-5);
  EXPECT_NEAR(alignment.scale, 1.0, 1e-5);
}

// 300 m at 10 m/s with 1.5 m of noise, a fifth of the fixes outliers, another clock. The information bound is one
// standard deviation of 0.22 m over the path, 0.11 degrees and 13 ms; it holds for root mean squares over seeds.
TEST(Alignment, HoldsThreeDecimetresAndAFifthOfADegreeWithAnOrdinaryReceiver) {
  constexpr int kTrials = 40;
  const auto path = drive(test::town());
  double path_square = 0.0;
  double rotation_square = 0.0;
  double offset_square = 0.0;
  int all_within = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937 random(3000U + static_cast<unsigned>(trial));
    const Receiver receiver{.T_map_world = any_placement(random, 0.0), .time_offset_s = -3.217, .outlier_share = 0.2};
    const Alignment alignment =
        align_or_fail(path, receive(path, receiver, random), {.freedom = Freedom::kYaw, .path_drift = 0.0});
    EXPECT_EQ(alignment.verdict, Verdict::kAligned) << alignment.reason;
    const auto error = error_of(alignment, receiver);
    const double path_m = path_error_m(alignment, receiver, path);
    const double rotation_deg = error.head<3>().norm() / kDegree;
    path_square += path_m * path_m / kTrials;
    rotation_square += rotation_deg * rotation_deg / kTrials;
    offset_square += error[6] * error[6] / kTrials;
    all_within += path_m < 0.3 && rotation_deg < 0.2 && std::abs(error[6]) < 0.020 ? 1 : 0;
  }
  RecordProperty("path_m", std::to_string(std::sqrt(path_square)));
  RecordProperty("rotation_deg", std::to_string(std::sqrt(rotation_square)));
  RecordProperty("offset_s", std::to_string(std::sqrt(offset_square)));
  RecordProperty("all_within", all_within);
  EXPECT_LT(std::sqrt(path_square), 0.3);
  EXPECT_LT(std::sqrt(rotation_square), 0.2);
  EXPECT_LT(std::sqrt(offset_square), 0.020);
}

TEST(Alignment, FindsATiltedCameraWithSixDegreesOfFreedom) {
  std::mt19937 random(21);
  const auto path = drive(test::flight());
  const Receiver receiver{.T_map_world = any_placement(random, 0.6), .time_offset_s = 0.4, .outlier_share = 0.1};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {.path_drift = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kAligned) << alignment.reason;
  EXPECT_LT(error_of(alignment, receiver).head<3>().norm(), 1.0 * kDegree);
  EXPECT_LT(path_error_m(alignment, receiver, path), 0.6);
}

struct Errors {
  double nees = 0.0;     ///< Mean squared normalised error of all unknowns together.
  double largest = 0.0;  ///< Of one trial.
  int aligned = 0;
};

Errors normalised_errors(const test::PathShape& shape, Freedom freedom, double correlation, int trials) {
  const auto path = drive(shape);
  Errors errors;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937 random(1000U + static_cast<unsigned>(trial));
    const Receiver receiver{.T_map_world = any_placement(random, freedom == Freedom::kYaw ? 0.0 : 0.5),
                            .time_offset_s = 0.2 * (trial % 9 - 4),
                            .correlation = correlation,
                            .outlier_share = 0.1};
    const AlignmentConfig config{.freedom = freedom, .max_time_offset_s = 2.0, .path_drift = 0.0};
    const Alignment alignment = align_or_fail(path, receive(path, receiver, random), config);
    const auto error = error_of(alignment, receiver);
    const std::vector<int> tested =
        freedom == Freedom::kYaw ? std::vector<int>{2, 3, 4, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
    const Eigen::MatrixXd covariance = alignment.covariance(tested, tested);
    const Eigen::VectorXd part = error(tested);
    const double offset = error[6] / alignment.time_offset_sigma_s;
    const double square = part.dot(covariance.ldlt().solve(part)) / static_cast<double>(tested.size());
    errors.nees += (square + offset * offset) / 2.0 / trials;
    errors.largest = std::max(errors.largest, square);
    errors.aligned += alignment.verdict == Verdict::kAligned ? 1 : 0;
  }
  return errors;
}

TEST(Alignment, SigmasAreHonestOverManySeeds) {
  constexpr int kTrials = 60;
  for (const Freedom freedom : {Freedom::kYaw, Freedom::kRotation}) {
    const Errors errors = normalised_errors(test::flight(), freedom, 0.0, kTrials);
    RecordProperty(freedom == Freedom::kYaw ? "nees_4" : "nees_6", std::to_string(errors.nees));
    // One for exact covariances; the apparent correlation of the noise makes it a little less.
    EXPECT_GT(errors.nees, 0.5);
    EXPECT_LT(errors.nees, 1.4);
    EXPECT_LT(errors.largest, 5.0);
    EXPECT_EQ(errors.aligned, kTrials);
  }
}

TEST(Alignment, SigmasAreHonestWhereNeighbouringFixesErrAlike) {
  constexpr int kTrials = 40;
  const Errors errors = normalised_errors(test::flight(), Freedom::kYaw, 0.9, kTrials);
  RecordProperty("nees", std::to_string(errors.nees));
  // A short recording shows only part of a slow error.
  EXPECT_GT(errors.nees, 0.3);
  EXPECT_LT(errors.nees, 3.0);
}

TEST(Alignment, TakesTheLeverArmIntoAccount) {
  std::mt19937 random(31);
  const auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0), .lever_arm_m = {0.5, -1.2, -2.0}, .noise_m = 0.05};
  const auto fixes = receive(path, receiver, random);
  const AlignmentConfig config{.freedom = Freedom::kYaw, .lever_arm_m = receiver.lever_arm_m, .path_drift = 0.0};
  const Alignment with = align_or_fail(path, fixes, config);
  EXPECT_LT(path_error_m(with, receiver, path), 0.03);
  const Alignment without = align_or_fail(path, fixes, {.freedom = Freedom::kYaw, .path_drift = 0.0});
  EXPECT_GT(path_error_m(without, receiver, path), 0.5);
}

TEST(Alignment, RefusesTheRotationAboutAStraightLine) {
  std::mt19937 random(41);
  const auto path = drive({});
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const auto fixes = receive(path, receiver, random);
  const Alignment alignment = align_or_fail(path, fixes, {.max_time_offset_s = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
  EXPECT_NE(alignment.reason.find("about the direction of travel"), std::string::npos) << alignment.reason;
  EXPECT_NE(alignment.reason.find("--dof 4"), std::string::npos) << alignment.reason;
}

TEST(Alignment, RefusesTheRotationAboutALineThatOnlyNoiseBends) {
  std::mt19937 random(42);
  auto path = drive({});
  std::normal_distribution<double> normal(0.0, 0.05);
  for (PathPose& pose : path) {
    pose.T_world_cam.translation += Eigen::Vector3d(normal(random), normal(random), normal(random));
  }
  const Receiver receiver{.T_map_world = any_placement(random, 0.0), .noise_m = 0.02};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {.max_time_offset_s = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
}

TEST(Alignment, AlignsHeadingAndPositionOnAStraightLine) {
  std::mt19937 random(43);
  const auto path = drive({});
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random),
                                            {.freedom = Freedom::kYaw, .max_time_offset_s = 0.0, .path_drift = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kAligned) << alignment.reason;
  EXPECT_LT(path_error_m(alignment, receiver, path), 0.4);
}

TEST(Alignment, RefusesPlaceAndTimeOffsetTogetherAtAConstantSpeedOnALine) {
  std::mt19937 random(44);
  const auto path = drive({});
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {.freedom = Freedom::kYaw});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
  EXPECT_NE(alignment.reason.find("time offset"), std::string::npos) << alignment.reason;
}

TEST(Alignment, RefusesTheHeadingOfAVerticalLine) {
  std::mt19937 random(45);
  test::PathShape shape;
  shape.pitch_rad = [](double) { return M_PI_2; };
  const auto path = drive(shape);
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment =
      align_or_fail(path, receive(path, receiver, random), {.freedom = Freedom::kYaw, .max_time_offset_s = 0.0});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
  EXPECT_NE(alignment.reason.find("heading"), std::string::npos) << alignment.reason;
}

TEST(Alignment, RefusesACameraAtRest) {
  std::mt19937 random(46);
  test::PathShape shape;
  shape.speed_mps = 1e-6;
  shape.length_m = 3e-5;
  const auto path = drive(shape);
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
}

TEST(Alignment, RefusesAReferenceOfAnotherTimeAndSaysWhichOffsetWouldDo) {
  std::mt19937 random(47);
  const auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0), .time_offset_s = 5000.0};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
  EXPECT_NE(alignment.reason.find("--time-offset 4999.9"), std::string::npos) << alignment.reason;
  EXPECT_EQ(alignment.fixes, 0);
  const AlignmentConfig there{.freedom = Freedom::kYaw, .time_offset_s = 4999.0, .path_drift = 0.0};
  std::mt19937 again(47);
  const Receiver same{.T_map_world = any_placement(again, 0.0), .time_offset_s = 5000.0};
  EXPECT_NEAR(align_or_fail(path, receive(path, same, again), there).time_offset_s, 5000.0, 0.05);
}

TEST(Alignment, NamesTheUnitOfTimesThatAreNotNanoseconds) {
  std::mt19937 random(51);
  const auto path = drive(test::town());
  const auto fixes = receive(path, {.T_map_world = any_placement(random, 0.0)}, random);
  for (const auto& [unit, nanoseconds] :
       {std::pair("microseconds", 1000), {"milliseconds", 1'000'000}, {"seconds", 1'000'000'000}}) {
    auto wrong = fixes;
    for (Fix& fix : wrong) {
      fix.time_ns /= nanoseconds;
    }
    const Alignment alignment = align_or_fail(path, wrong, {});
    EXPECT_NE(alignment.reason.find(std::string("times are in ") + unit), std::string::npos) << alignment.reason;
    EXPECT_EQ(alignment.reason.find("--time-offset"), std::string::npos) << alignment.reason;
  }
}

TEST(Alignment, AsksForALongerPathWhereFewFixesFallIntoIt) {
  std::mt19937 random(52);
  const auto whole = drive(test::town());
  const auto fixes = receive(whole, {.T_map_world = any_placement(random, 0.0)}, random);
  for (const std::ptrdiff_t begin : {0, 150}) {
    const std::vector<PathPose> path(whole.begin() + begin, whole.begin() + begin + 8);
    const Alignment alignment = align_or_fail(path, fixes, {});
    EXPECT_NE(alignment.reason.find("record a longer path"), std::string::npos) << alignment.reason;
    EXPECT_EQ(alignment.reason.find("--time-offset"), std::string::npos) << alignment.reason;
  }
}

TEST(Alignment, RefusesTheReferenceOfAnotherDrive) {
  std::mt19937 random(48);
  const auto path = drive(test::town());
  const auto other = drive(test::flight());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment = align_or_fail(path, receive(other, receiver, random), {.freedom = Freedom::kYaw});
  EXPECT_EQ(alignment.verdict, Verdict::kRefused);
}

TEST(Alignment, NeedsTenFixes) {
  std::mt19937 random(49);
  const auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0), .noise_m = 0.1};
  auto fixes = receive(path, receiver, random);
  std::vector<Fix> few;
  for (std::size_t i = 0; i < fixes.size(); i += fixes.size() / 9) {
    few.push_back(fixes[i]);
  }
  const AlignmentConfig config{.freedom = Freedom::kYaw, .max_time_offset_s = 0.0};
  few.resize(10);
  EXPECT_EQ(align_or_fail(path, few, config).verdict, Verdict::kAligned);
  few.pop_back();
  EXPECT_EQ(align_or_fail(path, few, config).verdict, Verdict::kRefused);
  EXPECT_EQ(align_or_fail(path, {}, config).verdict, Verdict::kRefused);
}

TEST(Alignment, LeavesOutFixesInGapsOfThePath) {
  std::mt19937 random(50);
  auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const auto fixes = receive(path, receiver, random);
  path.erase(path.begin() + 100, path.begin() + 150);
  const Alignment alignment = align_or_fail(path, fixes, {.freedom = Freedom::kYaw, .max_time_offset_s = 0.0});
  EXPECT_EQ(alignment.unmatched, 51);
  EXPECT_EQ(alignment.fixes + alignment.unmatched, static_cast<std::int64_t>(fixes.size()));
}

TEST(Alignment, RefusesSettingsOutOfRangeAndPosesOutOfOrder) {
  const auto path = drive(test::town());
  for (const AlignmentConfig& config :
       {AlignmentConfig{.lever_arm_m = {1e3, 0, 0}}, AlignmentConfig{.max_time_offset_s = -1.0},
        AlignmentConfig{.path_drift = std::nan("")}}) {
    const auto alignment = align(path, {}, config);
    ASSERT_FALSE(alignment);
    EXPECT_EQ(alignment.error().code, ErrorCode::kInvalidArgument);
  }
  auto disordered = path;
  std::swap(disordered[3], disordered[4]);
  EXPECT_FALSE(align(disordered, {}, {}));
  EXPECT_FALSE(align(std::span(path).first(1), {}, {}));
  for (const double far_m : {1e8, 1e300, std::nan("")}) {
    auto astray = path;
    astray[5].T_world_cam.translation.x() = far_m;
    EXPECT_FALSE(align(astray, {}, {})) << far_m;
  }
}

TEST(Alignment, PositionsAreLessSureFarFromThePath) {
  std::mt19937 random(51);
  const auto path = drive(test::town());
  const Receiver receiver{.T_map_world = any_placement(random, 0.0)};
  const Alignment alignment = align_or_fail(path, receive(path, receiver, random), {.freedom = Freedom::kYaw});
  const double here = position_covariance(alignment, alignment.center_m).trace();
  const double there = position_covariance(alignment, alignment.center_m + Eigen::Vector3d(500.0, 0.0, 0.0)).trace();
  EXPECT_NEAR(there - here, 500.0 * 500.0 * alignment.covariance(2, 2), 0.3 * there);
  EXPECT_GT(there, here);
}

TEST(NormalEquations, JacobiansAgreeWithDifferences) {
  std::mt19937 random(61);
  const auto path = drive(test::flight());
  const AntennaPath antenna(path, {.lever_arm_m = {0.3, -0.5, 1.0}});
  const Se3 T = any_placement(random, 0.4);
  // Within one step of the path, which is linear there.
  Match match{0, *antenna.at(path[50].time_ns + 40'000'000), Eigen::Vector3d(1, 2, 3), Eigen::Vector3d::Ones()};
  const Eigen::Vector3d center(10.0, -20.0, 5.0);
  const auto mapped = [&](const UnknownVector& x) -> Eigen::Vector3d {
    const PathPoint point = *antenna.at(path[50].time_ns + 40'000'000 + std::llround(x[kOffsetUnknown] * 1e9));
    const Eigen::Vector3d p = T * point.world_m;
    return center + (1.0 + x[kScaleUnknown]) * (so3_exp(x.head<3>()) * (p - center)) + x.segment<3>(3);
  };
  const Jacobian jacobian = linearise(std::span(&match, 1), T, center).front().jacobian;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kUnknowns; ++i) {
    UnknownVector step = UnknownVector::Zero();
    step[i] = kStep;
    const Eigen::Vector3d slope = (mapped(step) - mapped(-step)) / (2.0 * kStep);
    EXPECT_LT((slope - jacobian.col(i)).norm(), 1e-4 * std::max(1.0, slope.norm())) << i;
  }
}

TEST(NormalEquations, CorrelationTimeIsThatOfTheNoise) {
  std::mt19937 random(62);
  std::normal_distribution<double> normal;
  for (const double rho : {0.0, 0.5, 0.9}) {
    std::vector<Residual> residuals(20'000);
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    for (Residual& residual : residuals) {
      error =
          rho * error + std::sqrt(1.0 - rho * rho) * Eigen::Vector3d(normal(random), normal(random), normal(random));
      residual.error_m = error;
      residual.weight.setOnes();
    }
    const double expected = (1.0 + rho) / (1.0 - rho);
    EXPECT_NEAR(correlation_time(residuals), expected, 0.15 * expected);
  }
}

// A random walk of the path, measured without noise: the sigmas are those of the walk.
TEST(NormalEquations, SigmasCoverAPathThatDrifts) {
  constexpr int kTrials = 40;
  constexpr double kDrift = 0.01;
  double nees = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937 random(2000U + static_cast<unsigned>(trial));
    const auto truth = drive(test::town());
    auto path = truth;
    std::normal_distribution<double> step(0.0, kDrift * 300.0 / std::sqrt(static_cast<double>(path.size())));
    Eigen::Vector3d walked = Eigen::Vector3d::Zero();
    for (PathPose& pose : path) {
      pose.T_world_cam.translation += walked;
      walked += Eigen::Vector3d(step(random), step(random), step(random));
    }
    const Receiver receiver{.T_map_world = any_placement(random, 0.0), .noise_m = 0.05};
    const Alignment alignment =
        align_or_fail(path, receive(truth, receiver, random),
                      {.freedom = Freedom::kYaw, .max_time_offset_s = 0.0, .path_drift = kDrift});
    const double error = error_of(alignment, receiver)[2];
    nees += error * error / alignment.covariance(2, 2) / kTrials;
  }
  RecordProperty("nees", std::to_string(nees));
  EXPECT_GT(nees, 0.1);
  EXPECT_LT(nees, 1.6);
}

}  // namespace
}  // namespace kinetrace::geo
