#include "kinetrace/features/affine_template.hpp"

#include <cmath>

#include <Eigen/LU>

namespace kinetrace::features {

Eigen::Vector2d AffineTemplate::offset_px(int pixel) {
  const int row = pixel / kSide;
  return {pixel - row * kSide - kRadius_px, row - kRadius_px};
}

float AffineTemplate::normalise(Patch& patch) const {
  patch.array() -= patch.dot(weights_);
  const float spread = std::sqrt(patch.cwiseAbs2().dot(weights_));
  patch /= std::max(spread, 1e-3F);
  return spread;
}

/// Bilinear; false at the image's border.
bool AffineTemplate::sample(const GrayView& image, const AffinePlace& place, Patch& out) {
  const Eigen::Vector2d extent = kRadius_px * place.shape.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = place.position - extent;
  const Eigen::Vector2d high = place.position + extent;
  if (!(low.minCoeff() >= 1.0 && high.x() < image.width - 2 && high.y() < image.height - 2)) {
    return false;
  }
  for (int i = 0; i < kPixels; ++i) {
    const Eigen::Vector2d at = place.position + place.shape * offset_px(i);
    const int x0 = static_cast<int>(at.x());
    const int y0 = static_cast<int>(at.y());
    const auto ax = static_cast<float>(at.x() - x0);
    const auto ay = static_cast<float>(at.y() - y0);
    const std::uint8_t* upper = image.row(y0) + x0;
    const std::uint8_t* lower = image.row(y0 + 1) + x0;
    const float above = static_cast<float>(upper[0]) + ax * static_cast<float>(upper[1] - upper[0]);
    const float below = static_cast<float>(lower[0]) + ax * static_cast<float>(lower[1] - lower[0]);
    out[i] = above + ay * (below - above);
  }
  return true;
}

std::optional<AffineTemplate> AffineTemplate::make(const GrayView& image, const Eigen::Vector2d& at, double sigma_px) {
  constexpr float kFlat = 2.0F;
  AffineTemplate patch;
  for (int i = 0; i < kPixels; ++i) {
    patch.weights_[i] = static_cast<float>(std::exp(-offset_px(i).squaredNorm() / (2.0 * sigma_px * sigma_px)));
  }
  patch.weights_ /= patch.weights_.sum();
  Patch left, right, above, below;
  const Eigen::Vector2d x(1.0, 0.0);
  const Eigen::Vector2d y(0.0, 1.0);
  if (!(sample(image, {at}, patch.value_) && sample(image, {at - x}, left) && sample(image, {at + x}, right) &&
        sample(image, {at - y}, above) && sample(image, {at + y}, below))) {
    return std::nullopt;
  }
  const float spread = patch.normalise(patch.value_);
  if (spread < kFlat) {
    return std::nullopt;
  }
  const Patch dx = (right - left) / (2.0F * spread);
  const Patch dy = (below - above) / (2.0F * spread);
  Eigen::Matrix<float, kPixels, kParameters> derivative;
  for (int i = 0; i < kPixels; ++i) {
    const auto u = static_cast<float>(offset_px(i).x());
    const auto v = static_cast<float>(offset_px(i).y());
    derivative.row(i) << dx[i], dy[i], u * dx[i], v * dx[i], u * dy[i], v * dy[i], patch.value_[i], 1.0F;
  }
  patch.weighted_ = derivative.transpose() * patch.weights_.asDiagonal();
  patch.normal_.compute(patch.weighted_ * derivative);
  return patch.normal_.info() == Eigen::Success ? std::optional(patch) : std::nullopt;
}

std::optional<AffinePlace> AffineTemplate::align(const GrayView& image, const AffinePlace& guess,
                                                 const AffineGate& gate) const {
  constexpr int kIterations = 25;
  constexpr double kConverged_px = 0.003;
  AffinePlace place = guess;
  Patch seen;
  for (int i = 0; i < kIterations; ++i) {
    const double size = place.shape.determinant();
    if (!(size > 0.25 && size < 4.0) || !((place.position - guess.position).norm() < gate.reach_px) ||
        !sample(image, place, seen) || normalise(seen) < 1.0F) {
      return std::nullopt;
    }
    const Eigen::Matrix<double, kParameters, 1> step = normal_.solve(weighted_ * (seen - value_)).cast<double>();
    Eigen::Matrix2d stretch;
    stretch << 1.0 + step[2], step[3], step[4], 1.0 + step[5];
    place.shape = place.shape * stretch.inverse();
    place.position -= place.shape * step.head<2>();
    if (step.head<2>().norm() < kConverged_px) {
      const bool alike = seen.cwiseProduct(value_).dot(weights_) > gate.correlation;
      return alike ? std::optional(place) : std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace kinetrace::features
