// A textured world that can be sampled exactly anywhere, hence correspondences that are exact.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features::testing {

/// Sum of plane waves with equal power per octave, as in natural images; band-limited, so that sampling at points is
/// exact.
class Texture {
 public:
  explicit Texture(unsigned seed, double contrast_gray = 35.0, double shortest_px = 4.5, int waves = 48) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int i = 0; i < waves; ++i) {
      const double wavelength_px = shortest_px * std::pow(90.0 / shortest_px, uniform(random));
      const double direction = 2.0 * kPi * uniform(random);
      const double frequency = 1.0 / wavelength_px;
      waves_.push_back({frequency * std::cos(direction), frequency * std::sin(direction), uniform(random)});
    }
    amplitude_gray_ = contrast_gray * std::sqrt(2.0 / waves);
  }

  [[nodiscard]] double operator()(const Eigen::Vector2d& p) const {
    double value = 0.0;
    for (const Wave& wave : waves_) {
      value += cosine(wave.x * p.x() + wave.y * p.y() + wave.phase);
    }
    return 128.0 + amplitude_gray_ * value;
  }

 private:
  /// Frequencies and phase in turns.
  struct Wave {
    double x, y, phase;
  };

  /// Of an angle in turns, from a table: rendering would take most of the tests' time otherwise. Exact to 3e-7.
  static double cosine(double turns) {
    constexpr int kSteps = 4096;
    static const std::vector<double> table = [] {
      std::vector<double> values;
      for (int i = 0; i <= kSteps; ++i) {
        values.push_back(std::cos(2.0 * kPi * i / kSteps));
      }
      return values;
    }();
    const double position = (turns - std::floor(turns)) * kSteps;
    const auto index = static_cast<std::size_t>(position);
    const double next = index < kSteps ? table[index + 1] : table[0];
    return table[index] + (position - static_cast<double>(index)) * (next - table[index]);
  }

  static constexpr double kPi = 3.14159265358979323846;
  std::vector<Wave> waves_;
  double amplitude_gray_ = 0.0;
};

/// An 8-bit image that owns its pixels.
class Image {
 public:
  Image(int width, int height, std::uint8_t value = 0)
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width * height), value) {}
  [[nodiscard]] GrayView view() const { return {pixels_.data(), width_, height_, width_}; }
  [[nodiscard]] MutableGrayView pixels() { return {pixels_.data(), width_, height_, width_}; }

 private:
  int width_;
  int height_;
  std::vector<std::uint8_t> pixels_;
};

using PixelValue = std::function<double(const Eigen::Vector2d&)>;

/// Rounds `value(pixel)` plus Gaussian noise to 8 bits.
inline Image render(int width, int height, const PixelValue& value, double noise_gray = 0.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Image image(width, height);
  const MutableGrayView pixels = image.pixels();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double noisy = value({x, y}) + (noise_gray > 0.0 ? noise_gray * normal(random) : 0.0);
      pixels.at(x, y) = static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, noisy))));
    }
  }
  return image;
}

/// A plane seen by both views: disparity(x, y) = at_centre + gradient . ((x, y) - centre), in left coordinates.
struct DisparityPlane {
  double at_centre = 10.0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();

  [[nodiscard]] double operator()(const Eigen::Vector2d& left) const { return at_centre + gradient.dot(left - centre); }
  /// The left pixel seen at a right one: x_left - disparity(x_left, y) = x_right.
  [[nodiscard]] Eigen::Vector2d left_of(const Eigen::Vector2d& right) const {
    const double without_x = at_centre + gradient.y() * (right.y() - centre.y()) - gradient.x() * centre.x();
    return {(right.x() + without_x) / (1.0 - gradient.x()), right.y()};
  }
};

/// Both images of one frame.
struct StereoImage {
  Image left;
  Image right;
  [[nodiscard]] RectifiedPair pair(std::int64_t index = 0) const {
    RectifiedPair result;
    result.frame_index = index;
    result.timestamp_ns = index * 100'000'000;
    result.left = left.view();
    result.right = right.view();
    return result;
  }
};

/// A scene: the left image, and the disparity of the right one.
struct Scene {
  int width = 320;
  int height = 240;
  PixelValue left;
  DisparityPlane disparity;
  double row_offset_px = 0.0;  ///< Right image lower by this much.
  double right_gain = 1.0;
  double right_offset = 0.0;
  double noise_gray = 0.0;

  [[nodiscard]] StereoImage render(unsigned seed = 1) const {
    const auto right = [this](const Eigen::Vector2d& pixel) {
      const Eigen::Vector2d level(pixel.x(), pixel.y() - row_offset_px);
      return right_gain * (left(disparity.left_of(level)) - 128.0) + 128.0 + right_offset;
    };
    return {testing::render(width, height, left, noise_gray, 2 * seed),
            testing::render(width, height, right, noise_gray, 2 * seed + 1)};
  }
};

}  // namespace kinetrace::features::testing
