#include "kinetrace/tracking/similarity.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::tracking {
namespace {

/// Two points closer than this do not determine the scale.
constexpr double kMinSampleDistancePx = 4.0;
/// A larger change of scale in one frame is a wrong fit.
constexpr double kMaxScale = 2.0;

class Random {
 public:
  explicit Random(std::uint32_t seed) noexcept : state_(seed * 2654435761U + 88675123U) {}
  /// Uniform in [0, bound).
  std::size_t below(std::size_t bound) noexcept {  // xorshift32 (Marsaglia 2003)
    state_ ^= state_ << 13U;
    state_ ^= state_ >> 17U;
    state_ ^= state_ << 5U;
    return static_cast<std::size_t>((std::uint64_t{state_} * bound) >> 32U);
  }

 private:
  std::uint32_t state_;
};

bool plausible(const Similarity& s) noexcept {
  const double scale = s.scale();
  return scale > 1.0 / kMaxScale && scale < kMaxScale;
}

std::optional<Similarity> from_two(const PointPair& p, const PointPair& q) noexcept {
  const Eigen::Vector2d from = (q.from - p.from).cast<double>();
  const Eigen::Vector2d to = (q.to - p.to).cast<double>();
  const double length_sq = from.squaredNorm();
  if (length_sq < kMinSampleDistancePx * kMinSampleDistancePx) {
    return std::nullopt;
  }
  Similarity s;
  s.a = from.dot(to) / length_sq;
  s.b = (from.x() * to.y() - from.y() * to.x()) / length_sq;
  s.tx = static_cast<double>(p.to.x()) - s.a * static_cast<double>(p.from.x()) + s.b * static_cast<double>(p.from.y());
  s.ty = static_cast<double>(p.to.y()) - s.b * static_cast<double>(p.from.x()) - s.a * static_cast<double>(p.from.y());
  return plausible(s) ? std::optional(s) : std::nullopt;
}

bool supports(const Similarity& s, const PointPair& pair, double threshold_sq) noexcept {
  return (s * pair.from.cast<double>() - pair.to.cast<double>()).squaredNorm() <= threshold_sq;
}

std::size_t count_inliers(std::span<const PointPair> pairs, const Similarity& s, double threshold_sq) noexcept {
  return static_cast<std::size_t>(
      std::count_if(pairs.begin(), pairs.end(), [&](const PointPair& p) { return supports(s, p, threshold_sq); }));
}

/// Least squares on the pairs that support `start` (closed form: complex linear regression), with the standard error
/// it implies at `reach_px` from their centre.
struct Refined {
  Similarity similarity;
  double edge_error_px = 0.0;
};

std::optional<Refined> refine(std::span<const PointPair> pairs, const Similarity& start, double threshold_sq,
                              double reach_px) noexcept {
  Eigen::Vector2d mean_from = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_to = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (const PointPair& p : pairs) {
    if (supports(start, p, threshold_sq)) {
      mean_from += p.from.cast<double>();
      mean_to += p.to.cast<double>();
      n += 1.0;
    }
  }
  if (n < 3.0) {
    return std::nullopt;
  }
  mean_from /= n;
  mean_to /= n;
  double spread = 0.0;
  double dot = 0.0;
  double cross = 0.0;
  double spread_to = 0.0;
  for (const PointPair& p : pairs) {
    if (supports(start, p, threshold_sq)) {
      const Eigen::Vector2d f = p.from.cast<double>() - mean_from;
      const Eigen::Vector2d t = p.to.cast<double>() - mean_to;
      spread += f.squaredNorm();
      spread_to += t.squaredNorm();
      dot += f.dot(t);
      cross += f.x() * t.y() - f.y() * t.x();
    }
  }
  if (spread < kMinSampleDistancePx * kMinSampleDistancePx) {
    return std::nullopt;
  }
  Refined out;
  out.similarity.a = dot / spread;
  out.similarity.b = cross / spread;
  const Eigen::Vector2d t =
      mean_to - Eigen::Vector2d(out.similarity.a * mean_from.x() - out.similarity.b * mean_from.y(),
                                out.similarity.b * mean_from.x() + out.similarity.a * mean_from.y());
  out.similarity.tx = t.x();
  out.similarity.ty = t.y();
  const double residual = std::max(0.0, spread_to - (dot * dot + cross * cross) / spread);
  // Lower bound: features are accurate to a fifth of a pixel, however well a few of them happen to agree.
  const double sigma_sq = std::max(residual / std::max(1.0, 2.0 * n - 4.0), 0.04);
  out.edge_error_px = reach_px * std::sqrt(sigma_sq / spread);
  return plausible(out.similarity) ? std::optional(out) : std::nullopt;
}

}  // namespace

Similarity Similarity::operator*(const Similarity& other) const noexcept {
  const Eigen::Vector2d t = *this * Eigen::Vector2d(other.tx, other.ty);
  return {a * other.a - b * other.b, b * other.a + a * other.b, t.x(), t.y()};
}

Similarity Similarity::inverse() const noexcept {
  const double d = a * a + b * b;
  const double ia = a / d;
  const double ib = -b / d;
  return {ia, ib, -(ia * tx - ib * ty), -(ib * tx + ia * ty)};
}

double Similarity::scale() const noexcept {
  return std::hypot(a, b);
}

Similarity Similarity::about(const Eigen::Vector2d& center, double scale, const Eigen::Vector2d& shift) noexcept {
  const Eigen::Vector2d t = center + shift - scale * center;
  return {scale, 0.0, t.x(), t.y()};
}

std::optional<Similarity> fit_similarity(std::span<const PointPair> pairs, const SimilarityOptions& options,
                                         std::uint32_t seed) {
  if (pairs.size() < 3) {
    return std::nullopt;
  }
  const double threshold_sq = options.threshold_px * options.threshold_px;
  Random random(seed);
  std::optional<Similarity> best;
  std::size_t best_inliers = 2;
  for (int i = 0; i < options.iterations && best_inliers < pairs.size(); ++i) {
    const std::optional<Similarity> candidate =
        from_two(pairs[random.below(pairs.size())], pairs[random.below(pairs.size())]);
    if (!candidate) {
      continue;
    }
    const std::size_t inliers = count_inliers(pairs, *candidate, threshold_sq);
    if (inliers > best_inliers) {
      best = candidate;
      best_inliers = inliers;
    }
  }
  if (!best) {
    return std::nullopt;
  }
  const std::optional<Refined> refined = refine(pairs, *best, threshold_sq, options.reach_px);
  if (!refined || refined->edge_error_px > options.max_edge_error_px) {
    return std::nullopt;
  }
  return refined->similarity;
}

Eigen::Vector2d median_translation(std::span<const PointPair> pairs, std::span<float> scratch) {
  const auto median_of = [&](auto component) {
    const std::span<float> values = scratch.first(pairs.size());
    std::transform(pairs.begin(), pairs.end(), values.begin(), component);
    return double{median(values)};
  };
  return {median_of([](const PointPair& p) { return p.to.x() - p.from.x(); }),
          median_of([](const PointPair& p) { return p.to.y() - p.from.y(); })};
}

}  // namespace kinetrace::tracking
