// Points that are not their object's: wrong matches that were seen too seldom to be noticed while the run went on.
#pragma once

#include <cstdint>

#include "kinetrace/core/stereo_geometry.hpp"
#include "spool.hpp"
#include "spool_reader.hpp"

namespace kinetrace::recording {

/// A point of an object lies within its box, give or take what the box has not seen and what the point's own depth may
/// be wrong by. The largest box that the object ever had stands for it, since early ones hold only what was seen by
/// then.
class StrayPoints {
 public:
  /// `poses` is sorted by body and frame, open, and outlives this.
  StrayPoints(SpoolFile<PoseRecord>& poses, const StereoGeometry& geometry) : poses_(poses), geometry_(geometry) {}

  /// Asked in ascending order of bodies. The background, and objects that never had a box, have no stray points.
  [[nodiscard]] bool contains(const PointRecord& point);

 private:
  void go_to(std::uint32_t track_id);
  [[nodiscard]] double depth_deviation_m(const PointRecord& point);

  SpoolFile<PoseRecord>& poses_;
  const StereoGeometry& geometry_;
  std::uint32_t track_id_ = kBackgroundTrack;
  std::uint64_t first_ = 0;  ///< The body's records: [first_, last_).
  std::uint64_t last_ = 0;
  Eigen::Vector3d center_m_ = Eigen::Vector3d::Zero();  ///< Body frame.
  double radius_m_ = 0.0;                               ///< Of the sphere around the box.
};

}  // namespace kinetrace::recording
