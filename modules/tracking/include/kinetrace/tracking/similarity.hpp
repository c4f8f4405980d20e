// Image motion of an object between two frames: rotation, scale and translation.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

namespace kinetrace::tracking {

/// x' = a x - b y + tx, y' = b x + a y + ty. Four parameters model the image motion of a rigid object between two
/// frames well enough, the growth of oncoming ones included, and need only two points.
struct Similarity {
  double a = 1.0;
  double b = 0.0;
  double tx = 0.0;
  double ty = 0.0;

  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& p) const noexcept {
    return {a * p.x() - b * p.y() + tx, b * p.x() + a * p.y() + ty};
  }
  [[nodiscard]] Similarity operator*(const Similarity& other) const noexcept;
  [[nodiscard]] Similarity inverse() const noexcept;
  [[nodiscard]] double scale() const noexcept;

  /// Moves `center` by `shift` and scales about it.
  [[nodiscard]] static Similarity about(const Eigen::Vector2d& center, double scale,
                                        const Eigen::Vector2d& shift) noexcept;
};

/// The same image point in two frames.
struct PointPair {
  Eigen::Vector2f from{0.F, 0.F};
  Eigen::Vector2f to{0.F, 0.F};
};

struct SimilarityOptions {
  double threshold_px = 2.0;
  int iterations = 48;
  /// Maximum standard error at `reach_px` from the points' centre; a larger one refuses the fit.
  double max_edge_error_px = 4.0;
  double reach_px = 50.0;  ///< Half the size of the object's mask.
};

/// RANSAC on pairs of points, then least squares on the inliers. Nothing if fewer than three points are inliers, or if
/// they are too close together to separate scale from noise. Deterministic: the sampling sequence depends on `seed`
/// alone.
[[nodiscard]] std::optional<Similarity> fit_similarity(std::span<const PointPair> pairs,
                                                       const SimilarityOptions& options, std::uint32_t seed);

/// Component-wise median of the displacements; `scratch` holds at least pairs.size() values, `pairs` is not empty.
[[nodiscard]] Eigen::Vector2d median_translation(std::span<const PointPair> pairs, std::span<float> scratch);

}  // namespace kinetrace::tracking
