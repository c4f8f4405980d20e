#include "outlier_rounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::self_calibration {
namespace {

struct Round {
  bool rig_fixed;
  int iterations;
  double tolerance;
};

constexpr std::array<Round, 4> kFromAfar{{{false, 20, 1e-4}, {false, 20, 1e-4}, {false, 20, 1e-5}, {false, 30, 1e-5}}};
constexpr std::array<Round, 4> kFromNear{{{true, 15, 1e-4}, {false, 20, 1e-5}, {false, 30, 1e-5}, {false, 40, 1e-6}}};

/// 1.48 times the median magnitude of the residuals, per coordinate, each divided by its point's scale.
double robust_sigma_px(const RigModel& rig, const std::vector<BundleWindow>& windows) {
  constexpr double kFloor_px = 1e-3;
  std::vector<double> magnitudes;
  for (const BundleWindow& window : windows) {
    for (const BundlePoint& point : window.points) {
      if (point.used) {
        for (const Observation& seen : point.observations) {
          const Eigen::Vector2d r = residual_px(rig, window, point, seen);
          magnitudes.insert(magnitudes.end(),
                            {std::abs(r.x()) / point.sigma_scale, std::abs(r.y()) / point.sigma_scale});
        }
      }
    }
  }
  if (magnitudes.empty()) {
    return 1.0;
  }
  return std::max(1.4826 * median(magnitudes), kFloor_px);
}

struct TrackError {
  double rms_px = 0.0;  ///< Of a coordinate.
  double worst_px = 0.0;
};

TrackError track_error(const RigModel& rig, const BundleWindow& window, const BundlePoint& point) {
  double sum2 = 0.0;
  double worst2 = 0.0;
  for (const Observation& seen : point.observations) {
    const double r2 = 0.5 * residual_px(rig, window, point, seen).squaredNorm();
    sum2 += r2;
    worst2 = std::max(worst2, r2);
  }
  return {std::sqrt(sum2 / static_cast<double>(point.observations.size())), std::sqrt(worst2)};
}

bool fits(const BundlePoint& point, const TrackError& error, double sigma_px) {
  constexpr double kRmsSigmas = 3.0;
  constexpr double kWorstSigmas = 8.0;
  return point.ray_and_inverse_depth[2] > 0.0 && error.rms_px < kRmsSigmas * sigma_px &&
         error.worst_px < kWorstSigmas * sigma_px;
}

/// A track's own scatter, shrunk towards the common one for short tracks: its variance with an inverse-gamma prior.
double sigma_scale(const BundlePoint& point, const TrackError& error, double sigma_px) {
  constexpr double kPriorCoordinates = 8.0;
  const auto coordinates = static_cast<double>(2 * point.observations.size());
  const double relative = error.rms_px / sigma_px;
  return std::sqrt((kPriorCoordinates + coordinates * relative * relative) / (kPriorCoordinates + coordinates));
}

void reset_scales(std::vector<BundleWindow>& windows) {
  for (BundleWindow& window : windows) {
    for (BundlePoint& point : window.points) {
      point.sigma_scale = 1.0;
    }
  }
}

void reject_and_weigh(const RigModel& rig, std::vector<BundleWindow>& windows, double sigma_px) {
  for (BundleWindow& window : windows) {
    for (BundlePoint& point : window.points) {
      const TrackError error = track_error(rig, window, point);
      point.used = point.used && fits(point, error, sigma_px);
      point.sigma_scale = sigma_scale(point, error, sigma_px);
    }
  }
}

}  // namespace

Status adjust_in_rounds(RigModel& rig, std::vector<BundleWindow>& windows, RoundPlan plan, BundleOptions& options) {
  for (const Round& round : plan == RoundPlan::kFromAfar ? kFromAfar : kFromNear) {
    options.rig_fixed = round.rig_fixed;
    options.iterations = round.iterations;
    options.tolerance = round.tolerance;
    if (const Result<BundleResult> result = adjust(rig, windows, options); !result) {
      return Unexpected(result.error());
    }
    // First a common scale for rejection, then an individual one for each track.
    reset_scales(windows);
    options.sigma_px = robust_sigma_px(rig, windows);
    reject_and_weigh(rig, windows, options.sigma_px);
    options.sigma_px = robust_sigma_px(rig, windows);
  }
  return {};
}

double used_share(const std::vector<BundleWindow>& windows) {
  std::size_t used = 0;
  std::size_t all = 0;
  for (const BundleWindow& window : windows) {
    all += window.points.size();
    used += static_cast<std::size_t>(
        std::count_if(window.points.begin(), window.points.end(), [](const BundlePoint& p) { return p.used; }));
  }
  return static_cast<double>(used) / static_cast<double>(std::max<std::size_t>(all, 1));
}

}  // namespace kinetrace::self_calibration
