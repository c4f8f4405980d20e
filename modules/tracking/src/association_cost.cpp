#include "association_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace kinetrace::tracking {
namespace {

/// Expected new objects per frame that could be taken for a known one. With 1, returning objects become new ones; with
/// .1, known objects get what is at another depth.
constexpr double kNewObjects = 0.5;
/// Log ratio of the largest to the smallest object: log sizes of new ones are uniform over it.
constexpr double kLogSizeRange = 4.6;
/// Standard deviation of a mask's edge, and of the change of the outline with the viewpoint, relative to the size.
constexpr double kEdgeSigma_px = 1.5;
constexpr double kEdgeSigma = 0.04;
/// Additional relative one per occluded part: the whole of such an object has seldom been observed.
constexpr double kOccludedEdgeSigma = 0.2;
/// Bounds of the probability of an occluded edge: by an unknown occluder, and for a mostly occluded object that is
/// detected nevertheless.
constexpr double kMinOccluded = 0.005;
constexpr double kMaxOccluded = 0.5;
/// Probability that a feature stays on its object, and that it lies on another one by chance.
constexpr double kFeatureOnObjectProbability = 0.9;
constexpr double kFeatureOnOtherProbability = 0.02;
constexpr double kIndependentFeatures = 6.0;
/// Standard deviation of the disparities of one object: of its features, and by its depth extent relative to its
/// distance.
constexpr double kDisparitySigma_px = 0.5;
constexpr double kDepthExtent = 0.06;
constexpr double kDisparityRange_px = 30.0;  ///< Disparities of other objects are uniform over it.
/// Probability that a feature on a mask belongs to another surface, as near contours. A few may all do so.
constexpr double kOutlierFeatureProbability = 0.3;
constexpr std::size_t kMaxOutlierFeatures = 6;
constexpr double kDetectionProbability = 0.95;
constexpr double kMinDetectionProbability = 0.3;
/// Fragments of a detected object for each new one beside it.
constexpr double kFragmentsPerNew = 20.0;

double log_normal_peak(double sigma) {
  return -std::log(sigma) - 0.5 * std::log(2.0 * std::numbers::pi);
}

/// One of the four edges: measured against predicted.
struct Edge {
  int axis = 0;
  double side = 0.0;         ///< -1 for the lower one, 1 for the upper one.
  double extent_px = 0.0;    ///< Of the predicted box along the axis.
  double residual_px = 0.0;  ///< Measured minus predicted.

  double sigma_px = 0.0;  ///< Independent of the other edges.

  [[nodiscard]] double outward_px() const { return side * residual_px; }
};

/// Log density of the measured edges, all errors jointly normal.
double log_density(std::span<const Edge> edges, const BoxPrediction& predicted) {
  const auto count = static_cast<Eigen::Index>(edges.size());
  if (count == 0) {
    return 0.0;
  }
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;
  Matrix covariance(count, count);
  Vector residual(count);
  const double size_variance = 0.25 * predicted.size_sigma * predicted.size_sigma;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Edge& a = edges[static_cast<std::size_t>(i)];
    residual[i] = a.residual_px;
    for (Eigen::Index j = 0; j < count; ++j) {
      const Edge& b = edges[static_cast<std::size_t>(j)];
      covariance(i, j) =
          a.side * b.side * a.extent_px * b.extent_px * size_variance +
          (a.axis == b.axis ? predicted.position_sigma_px[a.axis] * predicted.position_sigma_px[a.axis] : 0.0) +
          (i == j ? a.sigma_px * a.sigma_px : 0.0);
    }
  }
  const Eigen::LLT<Matrix> solver(covariance);
  const Vector whitened = solver.matrixL().solve(residual);
  return -0.5 * whitened.squaredNorm() - Matrix(solver.matrixL()).diagonal().array().log().sum() -
         0.5 * static_cast<double>(count) * std::log(2.0 * std::numbers::pi);
}

/// Edges of the detection. One at the image border is measured only if it was predicted inside, and one beyond an edge
/// that the border had cut off never; otherwise it is censored.
std::span<const Edge> edges_of(const BoxPrediction& predicted, const PixelBox& detected, int width_px, int height_px,
                               std::array<Edge, 4>& edges) {
  const std::array<int, 4> at{detected.x0, detected.x1, detected.y0, detected.y1};
  const std::array<bool, 4> at_border{detected.x0 <= 0, detected.x1 >= width_px, detected.y0 <= 0,
                                      detected.y1 >= height_px};
  std::size_t count = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const auto axis = static_cast<int>(i / 2);
    const bool low = i % 2 == 0;
    const double extent_px = std::max(predicted.high_px[axis] - predicted.low_px[axis], 1.0);
    const double known_sigma_px = (low ? predicted.low_sigma_px : predicted.high_sigma_px)[axis];
    const double outline_px = (kEdgeSigma + kOccludedEdgeSigma * std::max(predicted.occluded, 0.0)) * extent_px;
    const Edge edge{.axis = axis,
                    .side = low ? -1.0 : 1.0,
                    .extent_px = extent_px,
                    .residual_px = at[i] - (low ? predicted.low_px : predicted.high_px)[axis],
                    .sigma_px = std::hypot(kEdgeSigma_px, known_sigma_px > 0.0 ? known_sigma_px : outline_px)};
    const bool was_cut = (low ? predicted.low_is_cut : predicted.high_is_cut)[static_cast<std::size_t>(axis)];
    if (edge.outward_px() > 0.0 ? !was_cut : !at_border[i]) {
      edges[count++] = edge;
    }
  }
  return std::span(edges).first(count);
}

/// The same where each edge is occluded with this probability, and then anywhere inside the predicted one: for the most
/// likely set of occluded edges, found one by one.
double log_density_if_occluded(std::span<const Edge> edges, const BoxPrediction& predicted, double occluded) {
  const auto density_of = [&](unsigned hidden) {
    std::array<Edge, 4> shown;
    std::size_t count = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if ((hidden >> i & 1U) != 0U) {
        sum += std::log(occluded) - std::log(edges[i].extent_px);
      } else {
        sum += std::log(1.0 - occluded);
        shown[count++] = edges[i];
      }
    }
    return sum + log_density(std::span(shown).first(count), predicted);
  };
  unsigned hidden = 0;
  double best = density_of(hidden);
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const unsigned before = hidden;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const unsigned with_this = before | 1U << i;
      if (with_this == before || edges[i].outward_px() >= 0.0) {
        continue;
      }
      if (const double density = density_of(with_this); density > best) {
        best = density;
        hidden = with_this;
      }
    }
    if (hidden == before) {
      break;
    }
  }
  return best;
}

}  // namespace

double box_evidence(const BoxPrediction& predicted, const PixelBox& detected, int width_px, int height_px) {
  std::array<Edge, 4> all;
  const std::span<const Edge> edges = edges_of(predicted, detected, width_px, height_px, all);
  const double occluded = std::clamp(predicted.occluded, kMinOccluded, kMaxOccluded);
  const double this_object = log_density_if_occluded(edges, predicted, occluded);
  // A new object: uniform position, log-uniform sizes. A censored edge contributes no factor.
  const double per_axis[2] = {-std::log(static_cast<double>(width_px)) - std::log(kLogSizeRange * detected.width()),
                              -std::log(static_cast<double>(height_px)) - std::log(kLogSizeRange * detected.height())};
  double new_object = std::log(kNewObjects);
  for (const int axis : {0, 1}) {
    const auto on_axis =
        std::count_if(edges.begin(), edges.end(), [axis](const Edge& edge) { return edge.axis == axis; });
    new_object += 0.5 * static_cast<double>(on_axis) * per_axis[axis];
  }
  return this_object - new_object;
}

double feature_evidence(double on_detection, int total) {
  if (total == 0) {
    return 0.0;
  }
  const double weight = kIndependentFeatures / (kIndependentFeatures + total);
  return weight *
         (on_detection * std::log(kFeatureOnObjectProbability / kFeatureOnOtherProbability) +
          (total - on_detection) * std::log((1.0 - kFeatureOnObjectProbability) / (1.0 - kFeatureOnOtherProbability)));
}

double disparity_evidence(double object_px, double object_sigma_px, double detection_px, std::size_t features) {
  if (object_px <= 0.0 || features == 0) {
    return 0.0;
  }
  const double sigma_px = std::hypot(kDisparitySigma_px, kDepthExtent * object_px, object_sigma_px);
  const double sigmas = (detection_px - object_px) / sigma_px;
  const double same = log_normal_peak(sigma_px) - 0.5 * sigmas * sigmas + std::log(kDisparityRange_px);
  const double all_outliers =
      static_cast<double>(std::min(features, kMaxOutlierFeatures)) * std::log(kOutlierFeatureProbability);
  return std::max(same, all_outliers);
}

double volume_evidence(const PredictedVolume& volume, std::span<const DisparitySample> samples) {
  double inside = 0.0;
  for (const DisparitySample& sample : samples) {
    inside += volume.density_at(sample.left_px.cast<double>(), sample.disparity_px, kDisparitySigma_px);
  }
  return feature_evidence(inside, static_cast<int>(samples.size()));
}

double extent_evidence(const ImageExtent& extent, const PixelBox& detected) {
  const Eigen::Vector2d centre_px(0.5 * (detected.x0 + detected.x1), 0.5 * (detected.y0 + detected.y1));
  const auto sigmas = [](double outside_px, double sigma_px) {
    return std::max(outside_px, 0.0) / std::hypot(kEdgeSigma_px, sigma_px);
  };
  double squared = 0.0;
  for (const int axis : {0, 1}) {
    const double below = sigmas(extent.low_px[axis] - centre_px[axis], extent.low_sigma_px[axis]);
    const double above = sigmas(centre_px[axis] - extent.high_px[axis], extent.high_sigma_px[axis]);
    squared += below * below + above * above;
  }
  return -0.5 * squared;
}

double detection_evidence(double visible) {
  const double detected = std::max(kMinDetectionProbability, kDetectionProbability * std::clamp(visible, 0.0, 1.0));
  return std::log(detected / (1.0 - detected));
}

double fragment_evidence(double overlap_fraction_with_others) {
  return std::log1p(kFragmentsPerNew * std::clamp(overlap_fraction_with_others, 0.0, 1.0));
}

}  // namespace kinetrace::tracking
