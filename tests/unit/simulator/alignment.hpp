// How well one picture, moved by the truth, lies on another.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include "util/image.hpp"

namespace kinetrace::simulator {

struct Alignment {
  int count = 0;                 ///< Pixels that were compared.
  double expected_share = 0.0;   ///< Of those that land in the target: where the target has the expected depth.
  double mean_abs_levels = 0.0;  ///< Difference of grey levels.
  Eigen::Vector2d offset_px{0,
                            0};  ///< By how much the target would have to move to fit best: zero if the truth is right.
};

struct Side {
  const Image<std::uint8_t>& picture;
  const Image<float>& depth_m;
};

/// Where a source pixel (u, v, depth) is in the target: (u, v, depth there); none if it is not to be compared.
using Warp = std::function<std::optional<Eigen::Vector3d>(int u, int v, double depth_m)>;

/// Compares all pixels of the source away from depth edges.
[[nodiscard]] Alignment align(const Side& source, const Side& target, const Warp& warp);

}  // namespace kinetrace::simulator
