// Alignment of a live run: from arriving poses and fixes to positions on the map.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/alignment_window.hpp"
#include "kinetrace/geo/geodesy.hpp"
#include "kinetrace/geo/reference.hpp"

namespace kinetrace::map {

/// Input of one alignment; a copy, since the window changes meanwhile.
struct AlignmentTask {
  std::vector<geo::PathPose> path;
  std::vector<geo::Fix> fixes;
  geo::AlignmentConfig config;
  double end_m = 0.0;         ///< Distance at the end of the path.
  std::int64_t restarts = 0;  ///< Of the window: identifies the world.
};

/// A point on the map, with covariance.
struct MapPlace {
  geo::Geodetic geodetic;
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< East, north, up; of the alignment and the path's drift.
};

class LiveAlignment {
 public:
  /// `origin`: of the map; by default the first fix. `offset_is_given`: config.time_offset_s is used; otherwise the
  /// reference is assumed to have the clock of the machine that publishes results.
  LiveAlignment(geo::AlignmentWindow window, const geo::AlignmentConfig& config, std::optional<geo::LocalFrame> frame,
                bool offset_is_given)
      : window_(std::move(window)), config_(config), frame_(std::move(frame)), offset_is_given_(offset_is_given) {}

  /// A frame or time not later than the one before belongs to another run. A pose beyond geo::kMaxPosition_m is
  /// skipped.
  void add_pose(std::int64_t frame_index, std::int64_t timestamp_ns, std::int64_t handed_over_ns,
                const Se3& T_world_cam);
  /// Ends the path: later poses are not connected with it.
  void lose_camera() noexcept;
  /// An invalid place is counted and skipped. Errors: those of geo::check_origin, for the first one that is valid.
  [[nodiscard]] Status add_fix(std::int64_t time_ns, const geo::Geodetic& place, const Eigen::Vector3d& sigma_m);
  void count_without_fix() noexcept;

  /// Whether fixes have come since the last task was filled in.
  [[nodiscard]] bool has_new_fixes() const noexcept;
  void fill(AlignmentTask& task);
  /// Takes the result of `task`; skipped if of another world. A determined alignment stays in use while newer stretches
  /// do not determine one.
  void accept(const AlignmentTask& task, const geo::Alignment& alignment);

  /// Whether an alignment was determined in this world.
  [[nodiscard]] bool is_aligned() const noexcept { return aligned_.has_value(); }
  /// Of the newest task; none before the first, and at the beginning of another world.
  [[nodiscard]] const std::optional<geo::Alignment>& newest() const noexcept { return newest_; }
  /// While aligned.
  [[nodiscard]] const geo::Alignment& aligned() const noexcept { return *aligned_; }
  [[nodiscard]] MapPlace place(const Eigen::Vector3d& world_m) const;
  [[nodiscard]] double horizontal_sigma_m() const;  ///< Of the camera's newest place.

  /// What is missing, or why nothing is published; empty while the newest stretch is aligned.
  [[nodiscard]] std::string reason() const;
  /// Of the reference, for reports.
  [[nodiscard]] geo::ReferenceCounts counts() const noexcept;
  [[nodiscard]] const std::optional<geo::LocalFrame>& frame() const noexcept { return frame_; }
  [[nodiscard]] bool has_poses() const noexcept { return has_poses_; }
  [[nodiscard]] bool has_fixes() const noexcept { return window_.counts().fixes > 0; }

 private:
  void leave_world() noexcept;

  geo::AlignmentWindow window_;
  geo::AlignmentConfig config_;
  std::optional<geo::LocalFrame> frame_;
  bool offset_is_given_;
  bool origin_is_checked_ = false;
  std::optional<std::int64_t> newest_frame_;
  std::optional<std::int64_t> latency_ns_;  ///< Least difference of the machine's clock to a pose's time.
  std::optional<geo::Alignment> newest_;
  std::optional<geo::Alignment> aligned_;
  double aligned_end_m_ = 0.0;                                ///< Distance at the end of the path used for it.
  Eigen::Vector3d newest_place_m_ = Eigen::Vector3d::Zero();  ///< Of the camera, in the world.
  geo::ReferenceCounts counts_;
  std::int64_t tried_fixes_ = 0;
  bool has_poses_ = false;
};

}  // namespace kinetrace::map
