#include <cmath>
#include <set>
#include <tuple>

#include <Eigen/Core>

#include "pixels.hpp"

namespace kinetrace::drawing {
namespace {

Eigen::Vector3d linear(const Color& c) {
  const auto channel = [](std::uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return {channel(c.r), channel(c.g), channel(c.b)};
}

// CIE 1976 L*a*b* of linear sRGB, white D65.
Eigen::Vector3d lab(const Eigen::Vector3d& rgb) {
  Eigen::Matrix3d to_xyz;
  to_xyz << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Eigen::Vector3d xyz = (to_xyz * rgb).cwiseQuotient(Eigen::Vector3d(0.9505, 1.0, 1.089));
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; };
  return {116.0 * f(xyz.y()) - 16.0, 500.0 * (f(xyz.x()) - f(xyz.y())), 200.0 * (f(xyz.y()) - f(xyz.z()))};
}

TEST(TrackStyle, DependsOnTheIdAlone) {
  for (const std::uint32_t id : {1U, 2U, 17U, 18U, 4'000'000'000U}) {
    EXPECT_EQ(track_style(id).color, track_style(id).color);
    EXPECT_EQ(track_style(id).dash, track_style(id).dash);
  }
  EXPECT_EQ(track_style(1).color, line_style(0).color);
  EXPECT_EQ(track_style(19).color, track_style(1).color);
  EXPECT_EQ(track_style(19).dash, track_style(1).dash);
  EXPECT_EQ(line_style(-1).color, line_style(kLineStyles - 1).color);
}

TEST(TrackStyle, StylesDiffer) {
  std::set<std::tuple<int, int, int, int>> styles;
  for (int i = 0; i < kLineStyles; ++i) {
    const LineStyle style = line_style(i);
    styles.insert({style.color.r, style.color.g, style.color.b, static_cast<int>(style.dash)});
  }
  EXPECT_EQ(styles.size(), static_cast<std::size_t>(kLineStyles));
}

TEST(TrackStyle, HuesStayApartForColourBlindReaders) {
  // Machado, Oliveira and Fernandes, "A physiologically-based model for simulation of color vision deficiency", 2009:
  // full protanopia and deuteranopia.
  Eigen::Matrix3d protan;
  protan << 0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998;
  Eigen::Matrix3d deutan;
  deutan << 0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881;
  constexpr int kHues = 6;
  for (const Eigen::Matrix3d& view : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), protan, deutan}) {
    for (int i = 0; i < kHues; ++i) {
      for (int j = 0; j < i; ++j) {
        const Eigen::Vector3d a = lab((view * linear(line_style(i).color)).cwiseMax(0.0).cwiseMin(1.0));
        const Eigen::Vector3d b = lab((view * linear(line_style(j).color)).cwiseMax(0.0).cwiseMin(1.0));
        // About 2.3 is just noticeable.
        EXPECT_GT((a - b).norm(), 10.0) << i << " and " << j;
      }
    }
  }
}

TEST(TrackStyle, ColoursAreVisibleOnPaper) {
  for (int i = 0; i < kLineStyles; ++i) {
    EXPECT_GT((lab(linear(line_style(i).color)) - lab(linear(kPaper))).norm(), 25.0) << i;
  }
}

TEST(Color, MixesAndFindsReadableText) {
  EXPECT_EQ(mix({0, 0, 0}, {200, 100, 50}, 0.5), (Color{100, 50, 25}));
  EXPECT_EQ(mix({7, 8, 9}, {200, 100, 50}, 0.0), (Color{7, 8, 9}));
  EXPECT_EQ(mix({7, 8, 9}, {200, 100, 50}, 1.0), (Color{200, 100, 50}));
  EXPECT_EQ(readable_on({255, 255, 255}), kInk);
  EXPECT_EQ(readable_on({0, 0, 0}), (Color{255, 255, 255}));
}

}  // namespace
}  // namespace kinetrace::drawing
