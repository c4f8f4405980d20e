#include "robust_loss.hpp"

namespace kinetrace::refinement {

double covariance_factor(double threshold) {
  // Midpoint rule over the norm of three Gaussian rows, density ~ n^2 exp(-n^2 / 2).
  constexpr int kSteps = 400;
  constexpr double kEnd = 8.0;
  const double scale = threshold * threshold;
  double weight = 0.0;
  double influence_squared = 0.0;
  double slope = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double norm = (i + 0.5) * kEnd / kSteps;
    const double s = norm * norm;
    const double p = s * std::exp(-0.5 * s);
    const double w = robust_weight(s, threshold);
    weight += p * w;
    influence_squared += p * w * w * s / 3.0;
    slope += p * (w - 2.0 / 3.0 * s * w * w / scale);
  }
  // The normalisation of the density cancels.
  return weight * influence_squared / (slope * slope);
}

}  // namespace kinetrace::refinement
