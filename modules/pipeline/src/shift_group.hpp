// Which of many likenesses between seen and remembered points agree on how an object has moved.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace kinetrace::pipeline {

/// A feature looks like a remembered point. Many do, few are it.
struct Likeness {
  std::uint16_t feature_slot = 0;
  std::uint16_t point = 0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< Where the feature is, less where the point was expected.
};

/// The likenesses that agree: one a feature, and one a point, at most.
struct ShiftGroup {
  static constexpr std::size_t kMaxMembers = 400;
  std::array<std::uint16_t, kMaxMembers> members{};  ///< Indices of likenesses; the first `count` are set.
  std::size_t count = 0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< Their mean.
};

/// The largest group whose shifts lie within `radius_m` of one of them that is no longer than `most_m`. A feature that
/// looks like several points at once (a fence, a tread), or several features that look like one point, are heard once,
/// by the nearest of their shifts. Of more than kMaxMembers likenesses the rest is left out.
[[nodiscard]] ShiftGroup largest_group(std::span<const Likeness> likenesses, double most_m, double radius_m);

}  // namespace kinetrace::pipeline
