// Limits that several parts of ObjectState go by.
#pragma once

namespace kinetrace::pipeline {

/// Of the position handed to the stereo-only filter by a reconstruction.
inline constexpr double kReconstructedSigma_m = 0.05;
/// Age of the velocity that a smoothed path ends with.
inline constexpr double kVelocityLag_s = 0.3;
/// What an acceleration is multiplied by to say how far off a place is after so long, s^2.
inline double acceleration_gain_s2(double unseen_s) noexcept {
  return unseen_s * (0.5 * unseen_s + kVelocityLag_s);
}
/// Error of a smoothed pose itself.
inline constexpr double kExpectedFloor_rad = 0.002;
/// From where it is expected, something at rest may be found so far away.
inline constexpr double kReachAtRest_m = 0.8;

}  // namespace kinetrace::pipeline
