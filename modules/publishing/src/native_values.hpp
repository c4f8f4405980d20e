// Single values as the native messages carry them.
#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinetrace.h"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::publishing {

[[nodiscard]] inline kinetrace_Vector3 to_wire(const Eigen::Vector3d& v) noexcept {
  return {v.x(), v.y(), v.z()};
}

[[nodiscard]] inline kinetrace_Pose to_wire(const Se3& pose) noexcept {
  const Eigen::Quaterniond q = pose.quaternion();
  return {to_wire(pose.translation), {q.x(), q.y(), q.z(), q.w()}};
}

// The numbers in the IDL are what other programs rely on; ours may be renumbered.
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

}  // namespace kinetrace::publishing
