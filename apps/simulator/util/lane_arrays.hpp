// Eight numbers at a time, in memory.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace kinetrace::simulator {

inline constexpr int kLanes = 8;
using Lanes = std::array<float, kLanes>;

struct alignas(32) Lanes3 {
  Lanes x{};
  Lanes y{};
  Lanes z{};

  void set(std::size_t lane, const Eigen::Vector3f& vector) noexcept {
    x[lane] = vector.x();
    y[lane] = vector.y();
    z[lane] = vector.z();
  }
};

}  // namespace kinetrace::simulator
