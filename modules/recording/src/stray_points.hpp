// Stray points of objects: wrong matches with too few observations to be rejected during the run.
#pragma once

#include <cstdint>

#include "kinetrace/core/stereo_geometry.hpp"
#include "spool.hpp"
#include "spool_reader.hpp"

namespace kinetrace::recording {

/// A point of an object must lie within its box, with a margin for unobserved parts and for the error of the point's
/// depth. The object's largest box counts, since early ones cover only the parts observed until then.
class StrayPoints {
 public:
  /// `poses` must be open, sorted by body and frame, and outlive this.
  StrayPoints(SpoolFile<PoseRecord>& poses, const StereoGeometry& geometry) : poses_(poses), geometry_(geometry) {}

  /// Call in ascending order of bodies. The background and objects without a box have no stray points.
  [[nodiscard]] bool contains(const PointRecord& point);

 private:
  void load_track(std::uint32_t track_id);
  [[nodiscard]] double depth_deviation_m(const PointRecord& point);

  SpoolFile<PoseRecord>& poses_;
  const StereoGeometry& geometry_;
  std::uint32_t track_id_ = kBackgroundTrack;
  std::uint64_t first_ = 0;  ///< The body's records: [first_, last_).
  std::uint64_t last_ = 0;
  Eigen::Vector3d center_m_ = Eigen::Vector3d::Zero();  ///< Body frame.
  double radius_m_ = 0.0;                               ///< Radius of the sphere around the box.
};

}  // namespace kinetrace::recording
