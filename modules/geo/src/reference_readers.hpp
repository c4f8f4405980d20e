// One reader for each format; `read_reference` makes a path of their results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "kinetrace/geo/reference.hpp"

namespace kinetrace::geo {

/// A fix as in its file.
struct FileFix {
  std::int64_t time_ns = 0;
  Geodetic place;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(1.0);
};

struct FileFixes {
  std::vector<FileFix> fixes;  ///< In the file's order; every position is valid.
  ReferenceCounts counts = {};
  std::vector<std::string> notes = {};
};

/// Default for receivers that report no errors: a horizontal standard deviation of 3 m under open sky (GPS Standard
/// Positioning Service Performance Standard, 2020: 8 m at 95 %), heights 1.5 times as large.
inline const Eigen::Vector3d kUsualSigma_m{3.0, 3.0, 4.5};

[[nodiscard]] Result<FileFixes> read_oxts(const std::filesystem::path& path);
[[nodiscard]] Result<FileFixes> read_nmea(const std::filesystem::path& path, std::int64_t near_time_ns);
[[nodiscard]] Result<FileFixes> read_gpx(const std::filesystem::path& path);
[[nodiscard]] Result<FileFixes> read_csv(const std::filesystem::path& path);
/// In metres relative to an origin, not in WGS84.
[[nodiscard]] Result<std::vector<Fix>> read_euroc(const std::filesystem::path& path);

}  // namespace kinetrace::geo
