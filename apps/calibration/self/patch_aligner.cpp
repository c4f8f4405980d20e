#include "patch_aligner.hpp"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetrace::self_calibration {
namespace {

constexpr int kRadius = PatchAligner::kRadius_px;
constexpr int kSide = 2 * kRadius + 1;
constexpr int kPixels = kSide * kSide;
using Patch = Eigen::Matrix<float, kPixels, 1>;

/// Bilinear samples of a square around `at`, `margin` wider than the patch; false at the image's border.
template <int Side>
bool sample(const cv::Mat& image, const Eigen::Vector2d& at, std::array<float, Side * Side>& out) {
  constexpr int kReach = Side / 2;
  const double left = at.x() - kReach;
  const double top = at.y() - kReach;
  if (!(left >= 0.0 && top >= 0.0 && left + Side < image.cols - 1 && top + Side < image.rows - 1)) {
    return false;
  }
  const int x0 = static_cast<int>(left);
  const int y0 = static_cast<int>(top);
  const auto ax = static_cast<float>(left - x0);
  const auto ay = static_cast<float>(top - y0);
  for (int y = 0; y < Side; ++y) {
    const float* upper = image.ptr<float>(y0 + y) + x0;
    const float* lower = image.ptr<float>(y0 + y + 1) + x0;
    for (int x = 0; x < Side; ++x) {
      const float above = upper[x] + ax * (upper[x + 1] - upper[x]);
      const float below = lower[x] + ax * (lower[x + 1] - lower[x]);
      out[static_cast<std::size_t>(y * Side + x)] = above + ay * (below - above);
    }
  }
  return true;
}

struct Template {
  Patch value;
  Eigen::Matrix<float, kPixels, 4> derivative;  ///< By x, y, gain, offset.
  Eigen::LLT<Eigen::Matrix4f> normal;
};

bool make_template(const cv::Mat& image, const Eigen::Vector2d& at, Template& patch) {
  constexpr int kWide = kSide + 2;
  std::array<float, kWide * kWide> wide;
  if (!sample<kWide>(image, at, wide)) {
    return false;
  }
  const auto pixel = [&](int x, int y) { return wide[static_cast<std::size_t>((y + 1) * kWide + x + 1)]; };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int i = y * kSide + x;
      patch.value[i] = pixel(x, y);
      patch.derivative.row(i) << 0.5F * (pixel(x + 1, y) - pixel(x - 1, y)), 0.5F * (pixel(x, y + 1) - pixel(x, y - 1)),
          pixel(x, y), 1.0F;
    }
  }
  // Centred and scaled, so that the normal matrix is well conditioned.
  const float mean = patch.value.mean();
  patch.value.array() -= mean;
  const float spread = std::sqrt(patch.value.squaredNorm() / kPixels);
  if (!(spread > 2.0F)) {
    return false;
  }
  patch.value /= spread;
  patch.derivative.leftCols<2>() /= spread;
  patch.derivative.col(2) = patch.value;
  patch.normal.compute(patch.derivative.transpose() * patch.derivative);
  return patch.normal.info() == Eigen::Success;
}

}  // namespace

std::optional<Eigen::Vector2d> PatchAligner::align(const cv::Mat& source, const Eigen::Vector2d& at,
                                                   const cv::Mat& target, const Eigen::Vector2d& guess,
                                                   double reach_px) {
  constexpr int kIterations = 25;
  constexpr double kConverged_px = 0.003;
  constexpr float kCorrelation = 0.8F;
  Template patch;
  if (!make_template(source, at, patch)) {
    return std::nullopt;
  }
  Eigen::Vector2d position = guess;
  std::array<float, kPixels> samples;
  for (int i = 0; i < kIterations; ++i) {
    if (!sample<kSide>(target, position, samples)) {
      return std::nullopt;
    }
    Patch seen = Eigen::Map<const Patch>(samples.data());
    seen.array() -= seen.mean();
    const float spread = std::sqrt(seen.squaredNorm() / kPixels);
    if (!(spread > 1.0F)) {
      return std::nullopt;
    }
    seen /= spread;
    const Eigen::Vector4f step = patch.normal.solve(patch.derivative.transpose() * (seen - patch.value));
    position -= step.head<2>().cast<double>();
    if ((position - guess).norm() > reach_px || !position.allFinite()) {
      return std::nullopt;
    }
    if (step.head<2>().norm() < kConverged_px) {
      const bool alike = seen.dot(patch.value) > kCorrelation * kPixels;
      return alike ? std::optional(position) : std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace kinetrace::self_calibration
