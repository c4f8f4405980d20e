#include "revisits.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::batch {
namespace {

// Two views share nothing at a distance of this many depths, or with 45 degrees between them.
constexpr double kApart_depths = 1.0;
constexpr double kApart_rad = 0.785;
// Limit for the sum of both: patches of one view are still found in the other.
constexpr double kAlike = 0.3;

/// 0: the same view; from 1 on: no overlap.
double separation(double distance_m, double turn_rad, double depth_m) {
  return distance_m / (kApart_depths * depth_m) + turn_rad / kApart_rad;
}

double turn_rad(const Se3& a, const Se3& b) {
  const double cosine = 0.5 * ((a.rotation.array() * b.rotation.array()).sum() - 1.0);
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

}  // namespace

double largest_drift_m(const Keyframe& from, const Keyframe& to) {
  constexpr double kDrift = 0.02;
  return kDrift * (to.travelled_m - from.travelled_m) + 2.0 * std::sqrt(to.variance_m2 - from.variance_m2);
}

std::vector<std::vector<std::size_t>> find_revisits(std::span<const Keyframe> keyframes,
                                                    std::span<const Se3> T_world_cam) {
  std::vector<std::vector<std::size_t>> revisits(keyframes.size());
  std::vector<bool> is_left(keyframes.size(), false);
  for (std::size_t j = 0; j < keyframes.size(); ++j) {
    const Se3& now = T_world_cam[keyframes[j].row];
    for (std::size_t i = 0; i < j; ++i) {
      const Keyframe& place = keyframes[i];
      const Se3& then = T_world_cam[place.row];
      const double distance_m = (now.translation - then.translation).norm();
      const double drift_m = largest_drift_m(place, keyframes[j]);
      const double turned_rad = turn_rad(then, now);
      if (is_left[i] && separation(std::max(0.0, distance_m - drift_m), turned_rad, place.depth_m) < kAlike) {
        revisits[j].push_back(i);
      }
      is_left[i] = is_left[i] || separation(distance_m, turned_rad, place.depth_m) > 1.0;
    }
  }
  return revisits;
}

}  // namespace kinetrace::batch
