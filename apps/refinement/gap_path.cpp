#include "gap_path.hpp"

#include <algorithm>

namespace kinetrace::batch {

GapPath GapPath::between(const recording::ObjectRow& from, const recording::ObjectRow& to) {
  return {from.box.center_m, to.box.center_m, from.velocity_mps, to.velocity_mps,
          1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns)};
}

Eigen::Vector3d GapPath::position_m(double s) const {
  const double s2 = s * s;
  const double s3 = s2 * s;
  return (2.0 * s3 - 3.0 * s2 + 1.0) * from_m + (s3 - 2.0 * s2 + s) * time_s * from_mps + (3.0 * s2 - 2.0 * s3) * to_m +
         (s3 - s2) * time_s * to_mps;
}

Eigen::Vector3d GapPath::velocity_mps(double s) const {
  return 6.0 * (s * s - s) / time_s * (from_m - to_m) + (3.0 * s * s - 4.0 * s + 1.0) * from_mps +
         (3.0 * s * s - 2.0 * s) * to_mps;
}

double GapPath::acceleration_mps2() const {
  const Eigen::Vector3d way = 6.0 / (time_s * time_s) * (to_m - from_m);
  const Eigen::Vector3d at_start = way - (4.0 * from_mps + 2.0 * to_mps) / time_s;
  const Eigen::Vector3d at_end = (2.0 * from_mps + 4.0 * to_mps) / time_s - way;
  return std::max(at_start.norm(), at_end.norm());
}

bool GapPath::is_possible(double max_s) const {
  constexpr double kAcceleration_mps2 = 3.0;
  constexpr double kPosition_m = 0.3;
  return time_s <= max_s && acceleration_mps2() <= kAcceleration_mps2 + 6.0 * kPosition_m / (time_s * time_s);
}

}  // namespace kinetrace::batch
