#include "kinetrace/features/affine_template.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace kinetrace::features {
namespace {

constexpr int kSize_px = 100;
constexpr double kSigma_px = 4.0;
constexpr AffineGate kGate{.reach_px = 3.0, .correlation = 0.9};

class Picture {
 public:
  /// Waves of several directions, seen through an affine map about the middle.
  static Picture of_waves(const Eigen::Matrix2d& shape, const Eigen::Vector2d& shift_px, double gain, double offset) {
    const Eigen::Vector2d centre(50.0, 50.0);
    Picture picture;
    for (int y = 0; y < kSize_px; ++y) {
      for (int x = 0; x < kSize_px; ++x) {
        const Eigen::Vector2d p = shape.inverse() * (Eigen::Vector2d(x, y) - centre - shift_px);
        const double value = 30.0 * std::sin(0.35 * p.x() + 0.2 * p.y()) +
                             25.0 * std::sin(0.3 * p.y() - 0.1 * p.x() + 1) + 0.02 * p.x() * p.y();
        picture.pixels_.push_back(static_cast<std::uint8_t>(std::lround(gain * (value + 130.0) + offset)));
      }
    }
    return picture;
  }
  static Picture of_one_tone() {
    Picture picture;
    picture.pixels_.assign(std::size_t{kSize_px} * kSize_px, 80);
    return picture;
  }

  [[nodiscard]] GrayView view() const { return {pixels_.data(), kSize_px, kSize_px, kSize_px}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

Picture waves_at(const Eigen::Vector2d& shift_px) {
  return Picture::of_waves(Eigen::Matrix2d::Identity(), shift_px, 1.0, 0.0);
}

TEST(AffineTemplate, FindsAPatchUnderAnAffineMapGainAndOffset) {
  Eigen::Matrix2d shape;
  shape << 1.15, 0.05, -0.04, 0.95;
  const auto patch = AffineTemplate::make(waves_at({0.0, 0.0}).view(), {50.0, 50.0}, kSigma_px);
  ASSERT_TRUE(patch);
  const Picture seen = Picture::of_waves(shape, {0.7, -0.4}, 0.8, 15.0);
  const auto place = patch->align(seen.view(), {{50.0, 50.0}}, kGate);
  ASSERT_TRUE(place);
  EXPECT_LT((place->position - Eigen::Vector2d(50.7, 49.6)).norm(), 0.02);
  EXPECT_LT((place->shape - shape).norm(), 0.03);
}

TEST(AffineTemplate, IsEmptyWhereNothingIsToBeSeen) {
  EXPECT_FALSE(AffineTemplate::make(Picture::of_one_tone().view(), {50.0, 50.0}, kSigma_px));
}

TEST(AffineTemplate, IsEmptyAtTheBorder) {
  const Picture waves = waves_at({0.0, 0.0});
  EXPECT_FALSE(AffineTemplate::make(waves.view(), {6.0, 50.0}, kSigma_px));
  EXPECT_TRUE(AffineTemplate::make(waves.view(), {11.0, 50.0}, kSigma_px));
}

TEST(AffineTemplate, DoesNotReachFartherThanAsked) {
  const auto patch = AffineTemplate::make(waves_at({0.0, 0.0}).view(), {50.0, 50.0}, kSigma_px);
  ASSERT_TRUE(patch);
  const Picture moved = waves_at({2.0, 0.0});
  EXPECT_TRUE(patch->align(moved.view(), {{50.0, 50.0}}, kGate));
  EXPECT_FALSE(patch->align(moved.view(), {{50.0, 50.0}}, {.reach_px = 1.0, .correlation = 0.9}));
}

}  // namespace
}  // namespace kinetrace::features
