#include "reference_path.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::geo {
namespace {

constexpr double kGapSteps = 3.0;
constexpr double kMaxSpeed_mps = 70.0;
constexpr double kNoiseSigmas = 4.0;  // Of the difference of two fixes.

double seconds(std::int64_t duration_ns) {
  return static_cast<double>(duration_ns) * 1e-9;
}

double median_step_s(const std::vector<Fix>& fixes) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    steps.push_back(seconds(fixes[i].time_ns - fixes[i - 1].time_ns));
  }
  return median(steps);
}

}  // namespace

void make_path(std::vector<Fix>& fixes, ReferenceCounts& counts) {
  // Files may begin with the newest fix or hold several tracks, and a single wrong time must not cost those after it.
  std::stable_sort(fixes.begin(), fixes.end(), [](const Fix& a, const Fix& b) { return a.time_ns < b.time_ns; });
  const auto repeated =
      std::unique(fixes.begin(), fixes.end(), [](const Fix& a, const Fix& b) { return a.time_ns == b.time_ns; });
  counts.repeated = fixes.end() - repeated;
  fixes.erase(repeated, fixes.end());
  if (fixes.size() < 2) {
    return;
  }
  const double usual_s = median_step_s(fixes);
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const double step_s = seconds(fixes[i].time_ns - fixes[i - 1].time_ns);
    if (step_s > kGapSteps * usual_s) {
      ++counts.gaps;
      counts.longest_gap_s = std::max(counts.longest_gap_s, step_s);
    }
    const double noise_m = std::sqrt(fixes[i].sigma_m.squaredNorm() + fixes[i - 1].sigma_m.squaredNorm());
    if ((fixes[i].enu_m - fixes[i - 1].enu_m).norm() > kMaxSpeed_mps * step_s + kNoiseSigmas * noise_m) {
      ++counts.jumps;
    }
  }
}

}  // namespace kinetrace::geo
