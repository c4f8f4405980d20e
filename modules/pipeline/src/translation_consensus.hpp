// Consensus of matches between observed and remembered points on an object's translation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace kinetrace::pipeline {

/// A feature that resembles a remembered point. Most matches are false.
struct AppearanceMatch {
  std::uint16_t feature_slot = 0;
  std::uint16_t point = 0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< Observed minus predicted position.
};

/// The matches that agree, at most one per feature and per point.
struct TranslationConsensus {
  static constexpr std::size_t kMaxMembers = 400;
  std::array<std::uint16_t, kMaxMembers> members{};  ///< Indices of matches; the first `count` are set.
  std::size_t count = 0;
};

/// The largest group whose shifts lie within `radius_m` of one of them, which is at most `max_shift_m` long. A feature
/// that resembles several points (a fence, a tread), or several features that resemble one point, count once, by the
/// nearest of their shifts. Matches beyond kMaxMembers are left out.
[[nodiscard]] TranslationConsensus largest_group(std::span<const AppearanceMatch> matches, double max_shift_m,
                                                 double radius_m);

}  // namespace kinetrace::pipeline
