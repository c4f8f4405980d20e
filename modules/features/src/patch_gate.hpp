// Gate for the similarity of two patches.
#pragma once

#include <Eigen/Core>

#include "kernel_types.hpp"

namespace kinetrace::features {

/// Correlation decides; on faint texture, where noise alone spoils it, the residual decides instead.
struct PatchGate {
  float min_correlation;
  float max_residual;
};

[[nodiscard]] inline bool looks_alike(const PatchFit& fit, const PatchGate& gate) noexcept {
  constexpr float kMinCorrelation = 0.5F;
  return fit.correlation >= gate.min_correlation ||
         (fit.residual_rms <= gate.max_residual && fit.correlation >= kMinCorrelation);
}

/// True if a full patch around the position lies in the image.
[[nodiscard]] inline bool patch_inside(const Plane& image, const Eigen::Vector2f& position_px) noexcept {
  return position_px.x() >= kPatchHalfWidth && position_px.y() >= kPatchHalfHeight &&
         position_px.x() <= static_cast<float>(image.width - 1) - kPatchHalfWidth &&
         position_px.y() <= static_cast<float>(image.height - 1) - kPatchHalfHeight;
}

}  // namespace kinetrace::features
