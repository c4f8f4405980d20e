// The records in DIR/.spool and their files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <tuple>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/recording/run_recorder.hpp"

namespace kinetrace::recording {

inline constexpr std::uint32_t kBackgroundTrack = 0;
inline constexpr std::uint32_t kNoPoint = 0;  ///< Point ids start at 1.

/// A pose as bytes.
struct StoredPose {
  std::array<double, 4> quaternion_xyzw{};
  std::array<double, 3> translation_m{};

  static StoredPose from(const Se3& pose) {
    const Eigen::Quaterniond q = pose.quaternion();
    return {{q.x(), q.y(), q.z(), q.w()}, {pose.translation.x(), pose.translation.y(), pose.translation.z()}};
  }
  [[nodiscard]] Se3 pose() const {
    const Eigen::Quaterniond q(quaternion_xyzw[3], quaternion_xyzw[0], quaternion_xyzw[1], quaternion_xyzw[2]);
    return {q.toRotationMatrix(), Eigen::Vector3d(translation_m.data())};
  }
};

/// Finalised pose of one body in one frame.
struct PoseRecord {
  std::uint32_t track_id = kBackgroundTrack;
  std::int32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t body_tracked = 0;   ///< 1: T_body_cam comes from the body's own reconstruction.
  std::uint32_t world_tracked = 0;  ///< 1: likewise the camera's pose (the paper's condition for a trajectory point).
  StoredPose T_body_cam;
  StoredPose T_world_body;
  std::array<float, 3> box_center_m{};  ///< Body frame.
  float box_radius_m = 0.F;             ///< Half the diagonal; 0 without a box.
};

/// Observation number `index` of a body in a frame.
struct ObservationRecord {
  std::uint32_t track_id = kBackgroundTrack;
  std::uint32_t point_id = kNoPoint;
  std::int32_t frame = 0;
  std::uint32_t index = 0;
  float u_px = 0.F;
  float v_px = 0.F;
};

/// A point in its final position.
struct PointRecord {
  std::uint32_t track_id = kBackgroundTrack;
  std::uint32_t point_id = kNoPoint;
  std::int32_t frame = 0;  ///< Frame in which the point left the map.
  std::array<float, 3> position_m{};
  float error_px = 0.F;
  std::uint16_t observations = 0;
  std::uint16_t intensity = 0;
};

/// File stem of a frame's rectified image, zero padded.
struct NameRecord {
  std::int32_t frame = 0;
  std::array<char, 76> stem{};
};
/// Appended to the stem of a recorded image that is not rectified, to distinguish the two.
inline constexpr std::string_view kRectifiedSuffix = "_rectified";

/// True if the COLMAP models are of the recorded images, under their names.
inline bool of_recorded_images(const RecordingConfig& config) {
  return config.is_rectified && !config.repeats;
}

inline bool by_body_and_frame(const PoseRecord& a, const PoseRecord& b) {
  return std::tie(a.track_id, a.frame) < std::tie(b.track_id, b.frame);
}
inline bool by_body_and_point(const PointRecord& a, const PointRecord& b) {
  return std::tie(a.track_id, a.point_id, a.frame) < std::tie(b.track_id, b.point_id, b.frame);
}
inline bool by_point(const ObservationRecord& a, const ObservationRecord& b) {
  return std::tie(a.track_id, a.point_id, a.frame, a.index) < std::tie(b.track_id, b.point_id, b.frame, b.index);
}
inline bool by_image(const ObservationRecord& a, const ObservationRecord& b) {
  return std::tie(a.track_id, a.frame, a.index) < std::tie(b.track_id, b.frame, b.index);
}

/// Folder and memory of `finish`.
struct Workspace {
  const RecordingConfig& config;
  std::span<std::byte> memory;

  /// Readers and writers that are open at the same time use different slices.
  static constexpr std::size_t kSlices = 8;
  [[nodiscard]] std::span<std::byte> slice(std::size_t i) const {
    constexpr std::size_t kUnit = Arena::kAlignment;
    const std::size_t bytes = memory.size() / kSlices / kUnit * kUnit;
    return memory.subspan(i * bytes, bytes);
  }
  [[nodiscard]] std::filesystem::path spool(std::string_view name) const { return config.directory / ".spool" / name; }
  [[nodiscard]] std::filesystem::path poses() const { return spool("poses.bin"); }
  [[nodiscard]] std::filesystem::path observations() const { return spool("observations.bin"); }
  [[nodiscard]] std::filesystem::path points() const { return spool("points.bin"); }
  [[nodiscard]] std::filesystem::path names() const { return spool("names.bin"); }
};

/// Counts of a run's rows and files.
struct RunCounts {
  std::uint64_t object_rows = 0;
  std::uint64_t label_rows = 0;
  std::uint64_t mask_rows = 0;
  std::uint64_t observations = 0;
  std::uint64_t images = 0;
  std::uint64_t stray_points = 0;  ///< Points left out as stray.
  std::uint64_t tracks = 0;
  std::uint64_t object_clouds = 0;
  std::uint64_t object_models = 0;
};

}  // namespace kinetrace::recording
