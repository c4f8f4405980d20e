#include "body_adjustment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <unordered_map>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::batch {
namespace {

// Matching is accurate to a tenth of a pixel; a larger sigma tolerates less accurate initial poses in the first round.
constexpr double kFirstSigma_px = 0.25;
constexpr double kMinSigma_px = 0.03;
constexpr double kMaxSigma_px = 1.0;
// Half the observations are downweighted: residuals of remaining wrong matches and of non-rigid surfaces are many times
// the noise.
constexpr double kRobustThreshold_sigmas = 1.0;
constexpr double kMinDisparity_px = 0.25;

struct Point {
  std::uint32_t id = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double weight = 0.0;  ///< Sum over the stereo positions it was averaged from.
  std::uint32_t last_frame = 0;
  int observations = 0;
  std::uint32_t index = 0;  ///< Within the adjustment.
};

class Adjustment {
 public:
  Adjustment(BodyProblem& problem, const AdjustmentOptions& options) : problem_(problem), options_(options) {}

  Result<BodyFit> run() {
    triangulate();
    list_observations();
    // The first rounds only estimate the noise, and how long it lasts.
    if (const Status solved = solve(10, 1e-3); !solved) {
      return Unexpected(solved.error());
    }
    sigma_px_ = weight_px_ = std::clamp(noise_px(), kMinSigma_px, kMaxSigma_px);
    if (const Status solved = solve(30, 1e-5); !solved) {
      return Unexpected(solved.error());
    }
    weight_px_ = std::clamp(noise_px() * std::sqrt(correlation_time()), sigma_px_, kMaxSigma_px);
    if (has_prior()) {
      if (const Status solved = solve(30, 1e-5); !solved) {
        return Unexpected(solved.error());
      }
    }
    place_single_points();
    BodyFit result = fit();
    if (const Status known = find_covariances(result); !known) {
      return Unexpected(known.error());
    }
    return result;
  }

 private:
  [[nodiscard]] bool has_stereo(const SeenPoint& seen) const {
    return !std::isnan(seen.px.z()) && seen.px.x() - seen.px.z() > kMinDisparity_px;
  }
  [[nodiscard]] Eigen::Vector3d stereo_position(const SeenPoint& seen, double& weight) const {
    const Eigen::Vector3d px = seen.px.cast<double>();
    const Eigen::Vector3d p_cam = problem_.geometry.triangulate(px.x(), px.y(), px.x() - px.z());
    weight = std::pow(p_cam.z(), -4.0);  // Depth uncertainty grows with the squared depth.
    return problem_.T_body_cam[seen.frame] * p_cam;
  }

  void triangulate() {
    for (const SeenPoint& seen : problem_.seen) {
      Point& point = points_[seen.point_id];
      point.id = seen.point_id;
      point.last_frame = std::max(point.last_frame, seen.frame);
      ++point.observations;
      if (has_stereo(seen)) {
        double weight = 0.0;
        const Eigen::Vector3d position_m = stereo_position(seen, weight);
        point.weight += weight;
        point.position_m += (position_m - point.position_m) * (weight / point.weight);
      }
    }
  }

  [[nodiscard]] static bool is_adjusted(const Point& point) { return point.observations > 1 && point.weight > 0.0; }

  void list_observations() {
    for (auto& [id, point] : points_) {
      if (is_adjusted(point)) {
        point.index = static_cast<std::uint32_t>(positions_.size());
        positions_.push_back(point.position_m);
      }
    }
    for (const SeenPoint& seen : problem_.seen) {
      if (const Point& point = points_.at(seen.point_id); is_adjusted(point)) {
        observations_.push_back({point.index, seen.frame, {seen.px.x(), seen.px.y(), seen.px.z(), 1.F}});
      }
    }
  }

  /// Whether the weight of the observations as a whole matters.
  [[nodiscard]] bool has_prior() const {
    return problem_.motion || !problem_.measured_poses.empty() || !problem_.measured_steps.empty();
  }

  Status solve(int max_iterations, double tolerance) {
    refinement::BatchProblem batch = batch_problem();
    auto adjuster = adjuster_for(max_iterations, tolerance);
    if (!adjuster) {
      return Unexpected(adjuster.error());
    }
    const auto solved = adjuster->refine_batch(batch);
    return solved ? Status() : Unexpected(solved.error());
  }

  /// By the present weight.
  [[nodiscard]] refinement::BatchProblem batch_problem() {
    for (refinement::BatchObservation& seen : observations_) {
      seen.observation.inverse_sigma_px = static_cast<float>(1.0 / weight_px_);
    }
    return {.geometry = problem_.geometry,
            .T_body_cam = problem_.T_body_cam,
            .fixed_frames = problem_.fixed_frames,
            .points_m = positions_,
            .observations = observations_,
            .motion = problem_.motion,
            .measured_poses = problem_.measured_poses,
            .measured_steps = problem_.measured_steps};
  }
  [[nodiscard]] Result<refinement::CeresBundleAdjuster> adjuster_for(int max_iterations, double tolerance) const {
    return refinement::CeresBundleAdjuster::create(
        {.max_iterations = max_iterations,
         .threads = options_.threads,
         // In terms of a single observation's noise.
         .robust_threshold_sigmas = kRobustThreshold_sigmas * sigma_px_ / weight_px_,
         .relative_cost_tolerance = tolerance,
         .keep_going = options_.keep_going});
  }

  Status find_covariances(BodyFit& fit) {
    if (!options_.with_covariances ||
        problem_.T_body_cam.size() > refinement::CeresBundleAdjuster::kMaxCovarianceFrames) {
      return {};
    }
    refinement::BatchProblem batch = batch_problem();
    const auto adjuster = adjuster_for(1, 0.0);
    if (!adjuster) {
      return Unexpected(adjuster.error());
    }
    Result<std::vector<Matrix6d>> covariances = adjuster->pose_covariances(batch);
    if (!covariances) {
      return Unexpected(covariances.error());
    }
    fit.covariances = std::move(*covariances);
    return {};
  }

  /// 1 + 2 sum of the autocorrelation of residuals along the tracks of points, as far as pairs of lags stay positive
  /// (Geyer 1992). Of long tracks only: in short ones, the point's own position absorbs most of it.
  [[nodiscard]] double correlation_time() const {
    constexpr std::size_t kMinTrack = 16;
    constexpr std::size_t kMaxLag = 15;
    std::unordered_map<std::uint32_t, std::vector<Eigen::Vector2d>> tracks;
    for (const SeenPoint& seen : problem_.seen) {
      const Point& point = points_.at(seen.point_id);
      if (static_cast<std::size_t>(point.observations) >= kMinTrack && is_adjusted(point)) {
        // Limits the influence of wrong matches.
        constexpr double kLimit_sigmas = 4.0;
        const double limit_px = kLimit_sigmas * sigma_px_;
        tracks[seen.point_id].push_back(
            residual_px(seen, positions_[point.index]).head<2>().cwiseMax(-limit_px).cwiseMin(limit_px));
      }
    }
    std::array<double, kMaxLag + 1> products{};
    for (const auto& [id, residuals] : tracks) {
      for (std::size_t lag = 0; lag <= kMaxLag; ++lag) {
        for (std::size_t k = lag; k < residuals.size(); ++k) {
          products[lag] += residuals[k].dot(residuals[k - lag]) / static_cast<double>(residuals.size() - lag);
        }
      }
    }
    double time = 1.0;
    for (std::size_t lag = 1; lag + 1 <= kMaxLag && products[lag] + products[lag + 1] > 0.0; lag += 2) {
      time += 2.0 * (products[lag] + products[lag + 1]) / products[0];
    }
    return std::max(time, 1.0);
  }

  /// Residual by the pose of the frame: u_left, v, u_right; NaN without a right match.
  [[nodiscard]] Eigen::Vector3d residual_px(const SeenPoint& seen, const Eigen::Vector3d& position_m) const {
    const Eigen::Vector3d p_cam = problem_.T_body_cam[seen.frame].inverse() * position_m;
    return problem_.geometry.project(p_cam) - seen.px.cast<double>();
  }

  /// From the median residual; as before with too few.
  [[nodiscard]] double noise_px() const {
    constexpr double kSigmaOfMedian = 1.4826;  // For a normal distribution.
    constexpr std::size_t kMinSizes = 100;
    std::vector<float> sizes;
    for (const SeenPoint& seen : problem_.seen) {
      const Point& point = points_.at(seen.point_id);
      if (!is_adjusted(point)) {
        continue;
      }
      const Eigen::Vector3d residual = residual_px(seen, positions_[point.index]);
      for (const double each : {residual.x(), residual.y(), residual.z()}) {
        if (!std::isnan(each)) {
          sizes.push_back(static_cast<float>(std::abs(each)));
        }
      }
    }
    if (sizes.size() < kMinSizes) {
      return sigma_px_;
    }
    return kSigmaOfMedian * double{median(sizes)};
  }

  void place_single_points() {
    for (auto& [id, point] : points_) {
      if (is_adjusted(point)) {
        point.position_m = positions_[point.index];
      }
    }
    for (const SeenPoint& seen : problem_.seen) {
      if (Point& point = points_.at(seen.point_id); point.observations == 1 && point.weight > 0.0) {
        double weight = 0.0;
        point.position_m = stereo_position(seen, weight);
      }
    }
  }

  [[nodiscard]] BodyFit fit() const {
    std::unordered_map<std::uint32_t, double> squares;
    for (const SeenPoint& seen : problem_.seen) {
      const Eigen::Vector3d residual = residual_px(seen, points_.at(seen.point_id).position_m);
      squares[seen.point_id] +=
          residual.head<2>().squaredNorm() + (std::isnan(residual.z()) ? 0.0 : residual.z() * residual.z());
    }
    BodyFit result;
    result.sigma_px = sigma_px_;
    for (const auto& [id, point] : points_) {
      if (point.weight > 0.0) {
        result.points.push_back({.id = id,
                                 .last_frame = point.last_frame,
                                 .position_m = point.position_m,
                                 .error_px = std::sqrt(squares[id] / point.observations),
                                 .observations = static_cast<std::uint16_t>(std::min(point.observations, 0xffff))});
      }
    }
    std::sort(result.points.begin(), result.points.end(),
              [](const RefinedPoint& a, const RefinedPoint& b) { return a.id < b.id; });
    return result;
  }

  BodyProblem& problem_;
  const AdjustmentOptions& options_;
  std::unordered_map<std::uint32_t, Point> points_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<refinement::BatchObservation> observations_;
  double sigma_px_ = kFirstSigma_px;   ///< Of an observation.
  double weight_px_ = kFirstSigma_px;  ///< Standard deviation by which it counts: that of the error it shares.
};

}  // namespace

Result<BodyFit> adjust_body(BodyProblem& problem, const AdjustmentOptions& options) {
  return Adjustment(problem, options).run();
}

}  // namespace kinetrace::batch
