// References: positions over time of a receiver or another, more accurate source.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"
#include "kinetrace/geo/geodesy.hpp"

namespace kinetrace::geo {

enum class ReferenceFormat : std::uint8_t {
  kOxts,   ///< KITTI: a folder with oxts/timestamps.txt and oxts/data/*.txt.
  kEuroc,  ///< `ns,x,y,z,...` in metres, z up, as EuRoC's ground truth.
  kNmea,   ///< NMEA 0183: GGA, with the date of RMC or ZDA.
  kGpx,    ///< GPX 1.0 or 1.1: track points with time.
  kCsv,    ///< Columns by name: timestamp_ns, latitude, longitude, height, and sigma_east to sigma_up.
};
inline constexpr std::array<std::pair<std::string_view, ReferenceFormat>, 5> kReferenceFormats{
    {{"oxts", ReferenceFormat::kOxts},
     {"euroc", ReferenceFormat::kEuroc},
     {"nmea", ReferenceFormat::kNmea},
     {"gpx", ReferenceFormat::kGpx},
     {"csv", ReferenceFormat::kCsv}}};
[[nodiscard]] std::string_view to_string(ReferenceFormat format) noexcept;

/// The reference's position at one time.
struct Fix {
  std::int64_t time_ns = 0;                         ///< Of the reference's own clock; UTC since 1970 if it is known.
  Eigen::Vector3d enu_m = Eigen::Vector3d::Zero();  ///< In `Reference::frame`.
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(1.0);  ///< East, north, up. Alignment uses only their ratios.
};

/// Statistics of reading.
struct ReferenceCounts {
  std::int64_t records = 0;        ///< Sentences, points or rows.
  std::int64_t bad_checksums = 0;  ///< NMEA; left out.
  std::int64_t malformed = 0;      ///< Truncated, or with values out of range; left out.
  std::int64_t without_fix = 0;    ///< The receiver itself reports no fix; left out.
  std::int64_t repeated = 0;       ///< In a file: of the same time as one before; left out.
  std::int64_t out_of_order = 0;   ///< In a live run: not later than the previous one; left out.
  std::int64_t gaps = 0;           ///< Steps longer than three times the usual one (median).
  double longest_gap_s = 0.0;
  std::int64_t jumps = 0;  ///< Steps of more than 70 m/s (250 km/h) plus noise. Kept: the alignment rejects outliers.
};

struct Reference {
  LocalFrame frame;        ///< Origin: as given, or the median of the fixes.
  std::vector<Fix> fixes;  ///< Ordered by time, no time twice; at least one.
  ReferenceCounts counts;
  std::vector<std::string> notes;  ///< For the user, one line each.
};

struct ReferenceSource {
  ReferenceFormat format = ReferenceFormat::kNmea;
  std::filesystem::path path;
  std::optional<Geodetic> origin;  ///< Of the map frame; required for kEuroc, whose metres are relative to it.
  std::int64_t near_time_ns = 0;   ///< Time of the recording: supplies the date of an NMEA log without one.
};

/// The map's vertical must be that of a valid place among the fixes. Errors: kInvalidArgument (more than 100 km away).
[[nodiscard]] Status check_origin(const LocalFrame& frame, const Geodetic& place);

/// Reads a reference. In logs of receivers (kNmea, kGpx), damaged records are left out and counted; tables (the other
/// formats) must be complete. Errors, with the file and, for tables, the line: kNotFound, kBadFormat (also: no fix at
/// all), kIo, kInvalidArgument (an origin is missing, not valid, or more than 100 km away).
[[nodiscard]] Result<Reference> read_reference(const ReferenceSource& source);

}  // namespace kinetrace::geo
