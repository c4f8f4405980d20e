// Agreement of one picture, moved by the truth, with another.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "util/image.hpp"

namespace kinetrace::simulator {

struct Alignment {
  int count = 0;                    ///< Pixels that were compared.
  double expected_share = 0.0;      ///< Share of pixels inside the target at which the target has the expected depth.
  double mean_abs_levels = 0.0;     ///< Difference of grey levels.
  Eigen::Vector2d offset_px{0, 0};  ///< Shift of the target for the best fit: zero if the truth is right.
};

struct Side {
  const Image<std::uint8_t>& picture;
  const Image<float>& depth_m;
};

/// Maps a source pixel (u, v, depth) to the target's (u, v, depth); none if it is not to be compared.
using Warp = std::function<std::optional<Eigen::Vector3d>(int u, int v, double depth_m)>;

/// Compares all pixels of the source away from depth edges.
[[nodiscard]] Alignment align(const Side& source, const Side& target, const Warp& warp);

}  // namespace kinetrace::simulator
