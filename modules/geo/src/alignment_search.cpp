#include "alignment_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::geo {
namespace {

// More fixes do not improve the start.
constexpr std::size_t kSearchFixes = 300;
// Inliers of the start lie within three standard deviations.
constexpr double kGateSigmas = 3.0;

/// A scalar instead of three: the closed form weights all axes alike.
double variance_m2(const Match& match, double drift_m) {
  return match.sigma_m.squaredNorm() / 3.0 + drift_m * drift_m;
}

struct Fit {
  Se3 T_map_world;
  double cost = std::numeric_limits<double>::infinity();
};

/// Graduated non-convexity with the loss of Geman and McClure: from least squares to a loss that ignores outliers (Yang
/// et al., RA-L 2020, sec. III). `cost` is the mean of squared residuals in units of the gate, each at most 1.
Fit fit_robustly(std::span<const Match> matches, Freedom freedom, double drift_m) {
  std::vector<double> gates_m2;
  std::vector<double> weights;
  for (const Match& match : matches) {
    gates_m2.push_back(kGateSigmas * kGateSigmas * variance_m2(match, drift_m));
    weights.push_back(1.0 / gates_m2.back());
  }
  std::vector<double> squares(matches.size());
  Fit fit;
  const auto update = [&] {
    fit.T_map_world = closed_form(matches, weights, freedom);
    double largest = 0.0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      squares[i] = (fit.T_map_world * matches[i].point.world_m - matches[i].enu_m).squaredNorm() / gates_m2[i];
      largest = std::max(largest, squares[i]);
    }
    return largest;
  };
  constexpr double kStep = 1.4;
  constexpr double kMaxControl = 1e12;
  double control = std::min(2.0 * update(), kMaxControl);
  while (control > 1.0) {
    for (std::size_t i = 0; i < matches.size(); ++i) {
      weights[i] = std::pow(control / (squares[i] + control), 2) / gates_m2[i];
    }
    update();
    control /= kStep;
  }
  fit.cost = 0.0;
  for (const double square : squares) {
    fit.cost += std::min(square, 1.0) / static_cast<double>(squares.size());
  }
  return fit;
}

/// Step between time offsets for which the path moves by less than the reference's noise.
double search_step_s(const AntennaPath& path, std::span<const Fix> fixes, double range_s) {
  const double duration_s = static_cast<double>(path.end_ns() - path.begin_ns()) * 1e-9;
  const double speed_mps = path.length_m() / std::max(duration_s, 1e-3);
  const double noise_m = fixes[fixes.size() / 2].sigma_m.norm();
  constexpr double kMinStep_s = 0.02;
  constexpr double kMaxSteps = 400.0;
  return std::max({std::min(noise_m / std::max(speed_mps, 0.1), 0.25), kMinStep_s, range_s / kMaxSteps});
}

}  // namespace

std::optional<AlignmentStart> search_start(const AntennaPath& path, std::span<const Fix> fixes,
                                           const AlignmentConfig& config) {
  const double range_s = config.max_time_offset_s;
  const auto range_ns = static_cast<std::int64_t>((std::abs(config.time_offset_s) + range_s) * 1e9);
  const auto within = std::count_if(fixes.begin(), fixes.end(), [&](const Fix& fix) {
    return fix.time_ns >= path.begin_ns() - range_ns && fix.time_ns <= path.end_ns() + range_ns;
  });
  const auto stride = std::max<std::size_t>(static_cast<std::size_t>(within) / kSearchFixes, 1);
  const double drift_m = config.path_drift * path.length_m();
  const double step_s = search_step_s(path, fixes, range_s);
  const int steps = static_cast<int>(std::ceil(range_s / step_s));
  std::optional<AlignmentStart> best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = -steps; i <= steps; ++i) {
    const double offset_s = config.time_offset_s + std::clamp(i * step_s, -range_s, range_s);
    const std::vector<Match> matches = match(path, fixes, offset_s, stride);
    if (matches.size() * stride < kMinFixes) {
      continue;
    }
    const Fit fit = fit_robustly(matches, config.freedom, drift_m);
    // Fixes outside of the path's time count as outliers; otherwise the best fit would be the one with the fewest
    // fixes.
    const double share =
        static_cast<double>(matches.size() * stride) / static_cast<double>(std::max<std::int64_t>(within, 1));
    const double cost = 1.0 - std::min(share, 1.0) * (1.0 - fit.cost);
    if (cost < least) {
      least = cost;
      best = AlignmentStart{fit.T_map_world, offset_s};
    }
  }
  return best;
}

}  // namespace kinetrace::geo
