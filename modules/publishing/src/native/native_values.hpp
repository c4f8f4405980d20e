// Conversion of single values to and from native messages.
#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinetrace.h"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::publishing {

[[nodiscard]] inline kinetrace_Vector3 to_wire(const Eigen::Vector3d& v) noexcept {
  return {v.x(), v.y(), v.z()};
}

[[nodiscard]] inline kinetrace_Pose to_wire(const Se3& pose) noexcept {
  const Eigen::Quaterniond q = pose.quaternion();
  return {to_wire(pose.translation), {q.x(), q.y(), q.z(), q.w()}};
}

[[nodiscard]] inline Eigen::Vector3d from_wire(const kinetrace_Vector3& v) noexcept {
  return {v.x, v.y, v.z};
}

[[nodiscard]] inline Se3 from_wire(const kinetrace_Pose& pose) noexcept {
  const kinetrace_Quaternion& q = pose.orientation;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(), from_wire(pose.position)};
}

// The numbers in the IDL are the interface to other programs; internal ones may change.
[[nodiscard]] constexpr std::uint8_t to_wire(BodyStatus status) noexcept {
  switch (status) {
    case BodyStatus::kInitializing: return kinetrace_STATUS_INITIALIZING;
    case BodyStatus::kTracked: return kinetrace_STATUS_TRACKED;
    case BodyStatus::kStereoOnly: return kinetrace_STATUS_STEREO_ONLY;
    case BodyStatus::kPropagated: return kinetrace_STATUS_PROPAGATED;
    case BodyStatus::kLost: return kinetrace_STATUS_LOST;
  }
  return kinetrace_STATUS_LOST;
}

[[nodiscard]] constexpr std::uint8_t to_wire(HealthState state) noexcept {
  switch (state) {
    case HealthState::kOk: return kinetrace_HEALTH_OK;
    case HealthState::kDegraded: return kinetrace_HEALTH_DEGRADED;
    case HealthState::kLost: return kinetrace_HEALTH_LOST;
  }
  return kinetrace_HEALTH_LOST;
}

[[nodiscard]] constexpr std::uint8_t to_wire(RigVerdict verdict) noexcept {
  switch (verdict) {
    case RigVerdict::kUnknown: return kinetrace_CALIBRATION_UNKNOWN;
    case RigVerdict::kHolds: return kinetrace_CALIBRATION_HOLDS;
    case RigVerdict::kOff: return kinetrace_CALIBRATION_OFF;
    case RigVerdict::kCorrected: return kinetrace_CALIBRATION_CORRECTED;
  }
  return kinetrace_CALIBRATION_UNKNOWN;
}

[[nodiscard]] constexpr RigVerdict rig_verdict(std::uint8_t verdict) noexcept {
  for (const RigVerdict known : {RigVerdict::kHolds, RigVerdict::kOff, RigVerdict::kCorrected}) {
    if (to_wire(known) == verdict) {
      return known;
    }
  }
  return RigVerdict::kUnknown;
}

/// Values of later versions are unknown and read as the worst.
[[nodiscard]] constexpr BodyStatus body_status(std::uint8_t status) noexcept {
  for (const BodyStatus known :
       {BodyStatus::kInitializing, BodyStatus::kTracked, BodyStatus::kStereoOnly, BodyStatus::kPropagated}) {
    if (to_wire(known) == status) {
      return known;
    }
  }
  return BodyStatus::kLost;
}
[[nodiscard]] constexpr HealthState health_state(std::uint8_t state) noexcept {
  for (const HealthState known : {HealthState::kOk, HealthState::kDegraded}) {
    if (to_wire(known) == state) {
      return known;
    }
  }
  return HealthState::kLost;
}

template <typename Vector, int N>
void copy_floats(const Vector& from, float (&to)[N]) noexcept {
  Eigen::Map<Eigen::Matrix<float, N, 1>>(static_cast<float*>(to)) = from.template cast<float>();
}

/// Row by row.
inline void copy_upper_triangle(const Matrix6d& from, float (&to)[21]) noexcept {
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = row; column < 6; ++column) {
      to[i++] = static_cast<float>(from(row, column));
    }
  }
}
[[nodiscard]] inline Matrix6d symmetric_from_upper_triangle(const float (&from)[21]) noexcept {
  Matrix6d to;
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = row; column < 6; ++column) {
      to(row, column) = to(column, row) = from[i++];
    }
  }
  return to;
}

}  // namespace kinetrace::publishing
