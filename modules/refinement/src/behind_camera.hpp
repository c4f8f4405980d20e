// What an observation costs whose point lies behind its camera: the same in every solver.
#pragma once

namespace kinetrace::refinement {

/// Nearer than this many baselines, a point counts as behind the camera.
inline constexpr double kMinDepthBaselines = 0.05;
/// Its residual norm, constant: no derivative, but a step that sends points behind cameras is never an improvement.
inline constexpr double kBehindCameraSigmas = 100.0;
/// The robust loss of that residual (Huber).
[[nodiscard]] constexpr double behind_camera_loss(double huber_sigmas) noexcept {
  return huber_sigmas * (2.0 * kBehindCameraSigmas - huber_sigmas);
}

}  // namespace kinetrace::refinement
