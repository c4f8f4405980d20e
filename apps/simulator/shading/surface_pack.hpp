// Surface points in the form of the shading kernels: eight at a time.
#pragma once

#include <Eigen/Core>

#include "util/lane_arrays.hpp"

namespace kinetrace::simulator {

/// Eight surface points under one paint, each with the ray that hit it. Unset lanes hold old values; their results are
/// meaningless.
struct alignas(32) SurfacePack {
  Lanes3 position;        ///< In the frame of the body it belongs to.
  Lanes3 normal;          ///< In the same frame.
  alignas(32) Lanes u{};  ///< Metres along and up the face.
  alignas(32) Lanes v{};
  alignas(32) Lanes footprint_m{};  ///< Size of a pixel there.
  Lanes3 scene_normal;              ///< Unit length, towards the viewer, scene frame.
  Lanes3 ray;                       ///< From the camera, of any length, scene frame.
  alignas(32) Lanes in_sun{};       ///< Fraction of the sun that is not blocked.
};

/// Points of a pixel on one flat surface, one for each of its samples; half a pack.
inline constexpr int kStripLanes = kLanes / 2;
using StripLanes = Eigen::Array<float, kStripLanes, 1>;

struct Strip3 {
  StripLanes x;
  StripLanes y;
  StripLanes z;

  [[nodiscard]] Eigen::Vector3f at(std::size_t lane) const noexcept {
    const auto i = static_cast<Eigen::Index>(lane);
    return {x[i], y[i], z[i]};
  }
};

struct SurfaceStrip {
  Strip3 ray;       ///< From the camera, of any length, scene frame.
  Strip3 position;  ///< In the frame of the body.
  StripLanes u;     ///< Metres along and up the face.
  StripLanes v;

  [[nodiscard]] Eigen::Vector2f uv_at(std::size_t lane) const noexcept {
    const auto i = static_cast<Eigen::Index>(lane);
    return {u[i], v[i]};
  }
};

}  // namespace kinetrace::simulator
