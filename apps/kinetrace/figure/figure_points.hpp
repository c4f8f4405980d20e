// Reads point clouds of a run folder, thinned on the fly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"

namespace kinetrace::figure {

struct CloudPoint {
  Eigen::Vector3f position_m{0.F, 0.F, 0.F};
  std::uint8_t gray = 0;
};

struct Cloud {
  std::vector<CloudPoint> points;
  std::size_t every = 1;  ///< Every n-th vertex of the file was taken.
};

/// Reads a binary little-endian PLY with float x, y, z and, if there is one, uchar red as the gray value; other
/// properties of fixed size are skipped. Takes every n-th vertex, with the smallest n that keeps at most `most`; memory
/// does not depend on the file's size. Points that are not finite are left out. Errors, with the file: kNotFound,
/// kBadFormat (another kind of file, or shorter than its header says).
[[nodiscard]] Result<Cloud> read_cloud(const std::filesystem::path& path, std::size_t most);

}  // namespace kinetrace::figure
