// The publisher's copy of a result.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// A reconstructed point, world frame.
struct PublishedPoint {
  Eigen::Vector3f position_m{0.F, 0.F, 0.F};
  std::uint32_t track_id = 0;  ///< 0 is the background.
  std::uint8_t intensity = 0;
};

/// The newest estimate of one frame. Objects and points have fixed capacities, from an arena.
struct KINETRACE_API PublishedFrame {
  PublishedFrame() = default;
  /// Capacities: config.max_objects and config.max_points.
  PublishedFrame(const PublishConfig& config, Arena& arena);

  /// Copies `result.newest`, and points of all its bodies that have a pose, thinned evenly to the capacity. Objects
  /// beyond the capacity are left out. `handed_over_ns` is the system clock (Unix). Never allocates.
  void assign(const FrameResult& result, std::int64_t handed_over_ns, std::int64_t exposed_ns = 0) noexcept;

  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::int64_t handed_over_ns = 0;
  std::int64_t exposed_ns = 0;  ///< Steady clock at mid-exposure; 0: not known. Not sent.
  CameraResult camera;
  FixedVector<ObjectResult> objects;
  FixedVector<PublishedPoint> points;
  std::size_t points_available = 0;  ///< Before thinning.
};

/// Health of the system, from its health monitor.
struct PublishedHealth {
  std::int64_t frame_index = -1;  ///< Newest processed frame; -1 before the first.
  std::int64_t handed_over_ns = 0;
  HealthState state = HealthState::kOk;
  std::string_view camera;                                ///< State of the camera; a string literal. Empty: unknown.
  std::array<HealthEntry, kHealthReasonCount> entries{};  ///< By HealthReason; a count of 0: never noted.
  FrameCounters counters;
  RigEstimate rig;  ///< As calibrated if there is no refinement.
};

/// A final pose of an object, or the end of its trajectory.
struct TrajectoryEvent {
  bool ends = false;  ///< End of the trajectory of `track_id`; has no pose.
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;
  BodyStatus status = BodyStatus::kLost;
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  Se3 T_world_obj;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

}  // namespace kinetrace::publishing
