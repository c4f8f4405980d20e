// Smooth path between two observed positions, and whether it is plausible.
#pragma once

#include <Eigen/Core>

#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::batch {

/// Cubic of positions from one end of a gap to the other, with the velocities there (Hermite).
struct GapPath {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero(), to_m = from_m, from_mps = from_m, to_mps = from_m;
  double time_s = 0.0;

  /// Of the boxes' centres.
  [[nodiscard]] static GapPath between(const recording::ObjectRow& from, const recording::ObjectRow& to);
  /// `s` in [0, 1].
  [[nodiscard]] Eigen::Vector3d position_m(double s) const;
  [[nodiscard]] Eigen::Vector3d velocity_mps(double s) const;
  /// The largest acceleration, at one of the ends: it is linear in between.
  [[nodiscard]] double acceleration_mps2() const;
  /// Whether usual braking and driving accelerations allow it, with a tolerance for position errors at both ends.
  [[nodiscard]] bool is_possible(double max_s) const;
};

}  // namespace kinetrace::batch
