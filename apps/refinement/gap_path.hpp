// The smooth path between two places where something was seen, and whether it can have gone that way.
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
  /// The largest on the way, which is at one of its ends: it is linear in between.
  [[nodiscard]] double acceleration_mps2() const;
  /// That of what brakes and engines usually do, with what positions at both ends may be off.
  [[nodiscard]] bool is_possible(double max_s) const;
};

}  // namespace kinetrace::batch
