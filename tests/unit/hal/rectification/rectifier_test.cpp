#include "kinetrace/hal/rectifier.hpp"

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rig_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

constexpr double kSpotSigma_px = 3.5;
constexpr int kSpotRadius_px = 14;

struct OwnedImage {
  OwnedImage(int width, int height) : pixels(static_cast<std::size_t>(width * height)), size{width, height} {}
  [[nodiscard]] MutableGrayView view() { return {pixels.data(), size[0], size[1], size[0]}; }
  std::vector<std::uint8_t> pixels;
  std::array<int, 2> size;
};

StereoFrame frame_of(GrayView left, GrayView right) {
  return {5, 8, "name", left, right};
}

bool is_inside(const Eigen::Vector2d& at, int width, int height) {
  return at.x() > kSpotRadius_px && at.y() > kSpotRadius_px && at.x() < width - 1 - kSpotRadius_px &&
         at.y() < height - 1 - kSpotRadius_px;
}

// Everything else becomes black.
void draw_spot(MutableGrayView image, const Eigen::Vector2d& at) {
  std::fill_n(image.data, image.stride * image.height, std::uint8_t{0});
  const int x0 = static_cast<int>(at.x());
  const int y0 = static_cast<int>(at.y());
  for (int y = y0 - kSpotRadius_px; y <= y0 + kSpotRadius_px; ++y) {
    for (int x = x0 - kSpotRadius_px; x <= x0 + kSpotRadius_px; ++x) {
      const double r2 = (Eigen::Vector2d(x, y) - at).squaredNorm();
      image.at(x, y) =
          static_cast<std::uint8_t>(std::lround(250 * std::exp(-r2 / (2 * kSpotSigma_px * kSpotSigma_px))));
    }
  }
}

// The peak of the spot: a polynomial of third order fitted to the logarithm of the brightness. Unlike the centre of
// mass, the peak does not move when the lens model stretches one side of the spot more than the other.
Eigen::Vector2d spot_position(GrayView image) {
  int peak_x = 0;
  int peak_y = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y) > image.at(peak_x, peak_y)) {
        peak_x = x;
        peak_y = y;
      }
    }
  }
  constexpr int kFitRadius_px = 7;
  using Row = Eigen::Matrix<double, 10, 1>;
  Eigen::Matrix<double, 10, 10> normal = Eigen::Matrix<double, 10, 10>::Zero();
  Row right_side = Row::Zero();
  for (int dy = -kFitRadius_px; dy <= kFitRadius_px; ++dy) {
    for (int dx = -kFitRadius_px; dx <= kFitRadius_px; ++dx) {
      const double value = image.contains(peak_x + dx, peak_y + dy) ? image.at(peak_x + dx, peak_y + dy) : 0;
      if (value < 8) {
        continue;
      }
      const double x = dx;
      const double y = dy;
      Row row;
      row << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
      const double weight =
          value * value;  // The rounding of the brightness is the same for all, that of its log is not.
      normal += weight * row * row.transpose();
      right_side += weight * std::log(value) * row;
    }
  }
  const Row c = normal.ldlt().solve(right_side);
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  for (int i = 0; i < 10; ++i) {  // Newton's method for the zero of the gradient.
    const double x = at.x();
    const double y = at.y();
    const Eigen::Vector2d gradient(c[1] + 2 * c[3] * x + c[4] * y + 3 * c[6] * x * x + 2 * c[7] * x * y + c[8] * y * y,
                                   c[2] + c[4] * x + 2 * c[5] * y + c[7] * x * x + 2 * c[8] * x * y + 3 * c[9] * y * y);
    Eigen::Matrix2d hessian;
    hessian << 2 * c[3] + 6 * c[6] * x + 2 * c[7] * y, c[4] + 2 * c[7] * x + 2 * c[8] * y,
        c[4] + 2 * c[7] * x + 2 * c[8] * y, 2 * c[5] + 2 * c[8] * x + 6 * c[9] * y;
    at -= hessian.inverse() * gradient;
  }
  return at + Eigen::Vector2d(peak_x, peak_y);
}

struct Observation {
  Eigen::Vector3d p_left;    // In the raw left camera's frame.
  Eigen::Vector3d measured;  // (u_left, v_left, u_right) after rectification.
  double v_right;
};

// Points at random depths, projected through both lens models, drawn, rectified and measured.
std::vector<Observation> observations(RigCalibration rig, Rectifier& rectifier, std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-0.7, 0.7);
  std::uniform_real_distribution<double> depth_m(0.8, 6.0);
  OwnedImage left(rig.left.width_px, rig.left.height_px);
  OwnedImage right(rig.left.width_px, rig.left.height_px);
  std::vector<Observation> found;
  while (found.size() < count) {
    const double z = depth_m(random);
    const Eigen::Vector3d p_left(z * std::tan(angle(random)), z * std::tan(angle(random)), z);
    const Eigen::Vector2d left_px = rig.left.project(p_left);
    const Eigen::Vector2d right_px = rig.right.project(rig.T_right_left * p_left);
    const Eigen::Vector3d roughly = rectifier.geometry().project(p_left);
    const StereoGeometry& g = rectifier.geometry();
    constexpr int kRotationMargin_px = 40;
    const bool visible = is_inside(left_px, rig.left.width_px, rig.left.height_px) &&
                         is_inside(right_px, rig.left.width_px, rig.left.height_px) &&
                         roughly.z() > kRotationMargin_px && roughly.x() < g.width_px - kRotationMargin_px &&
                         roughly.y() > kRotationMargin_px && roughly.y() < g.height_px - kRotationMargin_px;
    if (!visible) {
      continue;
    }
    draw_spot(left.view(), left_px);
    draw_spot(right.view(), right_px);
    const auto pair = rectifier.process(frame_of(left.view(), right.view()));
    const Eigen::Vector2d in_left = spot_position(pair->left);
    const Eigen::Vector2d in_right = spot_position(pair->right);
    found.push_back({p_left, {in_left.x(), in_left.y(), in_right.x()}, in_right.y()});
  }
  return found;
}

// The rotation that best turns a's onto b's (Kabsch, 1976).
Eigen::Matrix3d fitted_rotation(const std::vector<Observation>& points, const StereoGeometry& geometry) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const Observation& s : points) {
    const Eigen::Vector3d q = geometry.triangulate(s.measured.x(), s.measured.y(), s.measured.x() - s.measured.z());
    correlation += q * s.p_left.transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

struct RigCase {
  const char* name;
  RigCalibration (*make)();
};
class RectifierTruth : public ::testing::TestWithParam<RigCase> {};
INSTANTIATE_TEST_SUITE_P(Lenses, RectifierTruth,
                         ::testing::Values(RigCase{"radial", test::radial_rig}, RigCase{"fisheye", test::fisheye_rig},
                                           RigCase{"given", test::given_rig}),
                         [](const auto& rig_case) { return std::string(rig_case.param.name); });

TEST_P(RectifierTruth, ProjectedPointsObeyTheRectifiedGeometry) {
  const RigCalibration rig = GetParam().make();
  Arena arena(Rectifier::required_bytes(rig, {}));
  Result<Rectifier> rectifier = Rectifier::create(rig, {}, arena);
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  const StereoGeometry& geometry = rectifier->geometry();
  EXPECT_NEAR(geometry.baseline_m, rig.T_right_left.translation.norm(), 1e-6);

  const std::vector<Observation> points = observations(rig, *rectifier, 60);
  const Eigen::Matrix3d R_rect = fitted_rotation(points, geometry);
  double worst_row = 0;
  double worst = 0;
  for (const Observation& s : points) {
    worst_row = std::max(worst_row, std::abs(s.measured.y() - s.v_right));
    worst = std::max(worst, (s.measured - geometry.project(R_rect * s.p_left)).cwiseAbs().maxCoeff());
    EXPECT_NEAR(s.measured.y(), s.v_right, 0.05) << "rows differ at " << s.measured.transpose();
    const Eigen::Vector3d expected = geometry.project(R_rect * s.p_left);
    EXPECT_LT((s.measured - expected).cwiseAbs().maxCoeff(), 0.05)
        << "measured " << s.measured.transpose() << ", expected " << expected.transpose();
  }
  RecordProperty("worst_row_px", std::to_string(worst_row));
  RecordProperty("worst_px", std::to_string(worst));
  if (rig.given) {
    EXPECT_LT((R_rect - rig.given->R_left).cwiseAbs().maxCoeff(), 2e-4);
  }
}

TEST_P(RectifierTruth, SameInputGivesTheSameOutput) {
  const RigCalibration rig = GetParam().make();
  Arena arena(2 * Rectifier::required_bytes(rig, {}));
  Rectifier a = Rectifier::create(rig, {}, arena).value();
  Rectifier b = Rectifier::create(rig, {}, arena).value();
  OwnedImage image(rig.left.width_px, rig.left.height_px);
  draw_spot(image.view(), {300.25, 120.5});
  const StereoFrame frame = frame_of(image.view(), image.view());
  const RectifiedPair first = a.process(frame).value();
  const RectifiedPair second = b.process(frame).value();
  for (int y = 0; y < first.left.height; ++y) {
    ASSERT_TRUE(std::equal(first.left.row(y), first.left.row(y) + first.left.width, second.left.row(y)));
    ASSERT_TRUE(std::equal(first.right.row(y), first.right.row(y) + first.right.width, second.right.row(y)));
  }
}

TEST(Rectifier, KeepsGivenGeometryExactly) {
  const RigCalibration rig = test::given_rig();
  const StereoGeometry geometry = Rectifier::rectified_geometry(rig, {}).value();
  EXPECT_EQ(geometry.fx_px, 360.8);
  EXPECT_EQ(geometry.cx_px, 304.8);
  EXPECT_EQ(geometry.cy_px, 86.4);
  EXPECT_EQ(geometry.width_px, 620);
  EXPECT_EQ(geometry.height_px, 188);
}

TEST(Rectifier, LeavesNoBlankBordersByDefault) {
  const RigCalibration rig = test::radial_rig();
  const StereoGeometry cropped = Rectifier::rectified_geometry(rig, {}).value();
  const StereoGeometry whole = Rectifier::rectified_geometry(rig, {.keep_borders = 1.0}).value();
  EXPECT_GT(cropped.fx_px, whole.fx_px);
}

TEST(Rectifier, RepeatsTheBorderWhereThereIsNoImage) {
  const RigCalibration rig = test::radial_rig();
  const RectifierConfig config{.keep_borders = 1.0};
  Arena arena(Rectifier::required_bytes(rig, config));
  Rectifier rectifier = Rectifier::create(rig, config, arena).value();
  OwnedImage image(rig.left.width_px, rig.left.height_px);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{77});
  const RectifiedPair pair = rectifier.process(frame_of(image.view(), image.view())).value();
  EXPECT_EQ(pair.left.at(0, 0), 77);
  EXPECT_EQ(pair.right.at(pair.right.width - 1, pair.right.height - 1), 77);
}

TEST(Rectifier, PassesRectifiedPairsThroughWithoutACopy) {
  const RigCalibration rig = test::rectified_rig();
  EXPECT_EQ(Rectifier::required_bytes(rig, {}), 0U);
  Arena arena(64);
  Rectifier rectifier = Rectifier::create(rig, {}, arena).value();
  EXPECT_TRUE(rectifier.passes_through());
  OwnedImage left(48, 32);
  OwnedImage right(48, 32);
  const RectifiedPair pair = rectifier.process(frame_of(left.view(), right.view())).value();
  EXPECT_EQ(pair.left.data, left.pixels.data());
  EXPECT_EQ(pair.right.data, right.pixels.data());
  EXPECT_EQ(pair.frame_index, 5);
  EXPECT_EQ(pair.timestamp_ns, 8);
  EXPECT_EQ(pair.name, "name");
  EXPECT_EQ(pair.geometry.baseline_m, 0.5);
}

TEST(Rectifier, PassesThroughWhereTheGivenRectificationChangesNothing) {
  RigCalibration rig = test::given_rig();
  for (CameraModel* view : {&rig.left, &rig.right}) {
    *view = {.width_px = 620, .height_px = 188, .fx_px = 360.8, .fy_px = 360.8, .cx_px = 304.8, .cy_px = 86.4};
  }
  rig.given->R_left.setIdentity();
  rig.given->R_right.setIdentity();
  Arena arena(64);
  const Result<Rectifier> rectifier = Rectifier::create(rig, {}, arena);
  ASSERT_TRUE(rectifier);
  EXPECT_TRUE(rectifier->passes_through());
}

TEST(Rectifier, RefusesImagesOfAnotherSize) {
  const RigCalibration rig = test::radial_rig();
  Arena arena(Rectifier::required_bytes(rig, {}));
  Rectifier rectifier = Rectifier::create(rig, {}, arena).value();
  OwnedImage fits(752, 480);
  OwnedImage other(752, 479);
  const auto pair = rectifier.process(frame_of(fits.view(), other.view()));
  ASSERT_FALSE(pair);
  EXPECT_EQ(pair.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(pair.error().message, HasSubstr("frame 5 is 752x479"));
}

TEST(Rectifier, TakesExactlyWhatItAnnounces) {
  const RigCalibration rig = test::given_rig();
  const std::size_t bytes = Rectifier::required_bytes(rig, {});
  Arena exact(bytes);
  ASSERT_TRUE(Rectifier::create(rig, {}, exact));
  EXPECT_EQ(exact.used_bytes(), bytes);
  Arena small(bytes - Arena::kAlignment);
  const auto refused = Rectifier::create(rig, {}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

TEST(Rectifier, RefusesImagesThatHaveNoNeighbours) {
  RigCalibration rig = test::radial_rig();
  for (CameraModel* camera : {&rig.left, &rig.right}) {
    camera->width_px = 1;
    camera->cx_px = 0.0;
  }
  Arena arena(std::size_t{4} << 20U);
  const auto created = Rectifier::create(rig, {}, arena);
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().code, ErrorCode::kBadCalibration);
}

TEST(Rectifier, ReportsInvalidCalibrationAndConfiguration) {
  RigCalibration rig = test::radial_rig();
  rig.left.fx_px = std::nan("");
  EXPECT_EQ(Rectifier::required_bytes(rig, {}), 0U);
  EXPECT_EQ(Rectifier::rectified_geometry(rig, {}).error().code, ErrorCode::kBadCalibration);
  const auto bad_config = Rectifier::rectified_geometry(test::radial_rig(), {.keep_borders = 1.5});
  EXPECT_EQ(bad_config.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(bad_config.error().message, HasSubstr("rectifier.keep_borders must be in [0, 1], got 1.5"));
  RigCalibration mixed = test::radial_rig();
  mixed.right.lens = LensModel::kEquidistant;
  EXPECT_EQ(Rectifier::rectified_geometry(mixed, {}).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace kinetrace::hal
