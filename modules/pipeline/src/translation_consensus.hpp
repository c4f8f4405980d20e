// Which of many matches between seen and remembered points agree on how an object has moved.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace kinetrace::pipeline {

/// A feature looks like a remembered point. Many do, few are it.
struct AppearanceMatch {
  std::uint16_t feature_slot = 0;
  std::uint16_t point = 0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< Where the feature is, less where the point was expected.
};

/// The matches that agree: one a feature, and one a point, at most.
struct TranslationConsensus {
  static constexpr std::size_t kMaxMembers = 400;
  std::array<std::uint16_t, kMaxMembers> members{};  ///< Indices of matches; the first `count` are set.
  std::size_t count = 0;
};

/// The largest group whose shifts lie within `radius_m` of one of them that is no longer than `most_m`. A feature that
/// looks like several points at once (a fence, a tread), or several features that look like one point, count once, by
/// the nearest of their shifts. Of more than kMaxMembers matches the rest is left out.
[[nodiscard]] TranslationConsensus largest_group(std::span<const AppearanceMatch> matches, double most_m,
                                                 double radius_m);

}  // namespace kinetrace::pipeline
