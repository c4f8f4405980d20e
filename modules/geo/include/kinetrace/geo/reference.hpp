// References: where a receiver, or whoever knew better, was at which time.
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
  std::int64_t time_ns = 0;                         ///< Of the reference's own clock; UTC since 1970 where it knows.
  Eigen::Vector3d enu_m = Eigen::Vector3d::Zero();  ///< In `Reference::frame`.
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(1.0);  ///< East, north, up. Alignment takes its ratios only.
};

/// What was met while reading.
struct ReferenceCounts {
  std::int64_t records = 0;        ///< Sentences, points or rows.
  std::int64_t bad_checksums = 0;  ///< NMEA; left out.
  std::int64_t malformed = 0;      ///< Cut, or with values out of range; left out.
  std::int64_t without_fix = 0;    ///< The receiver says itself that it has none; left out.
  std::int64_t out_of_order = 0;   ///< Not later than the one before; left out.
  std::int64_t gaps = 0;           ///< Steps longer than three times the usual one (median).
  double longest_gap_s = 0.0;
  std::int64_t jumps = 0;  ///< Steps of more than 70 m/s (250 km/h) and the noise. Kept: the alignment judges them.
};

struct Reference {
  LocalFrame frame;        ///< Origin: what was given, or the middle (median) of the fixes.
  std::vector<Fix> fixes;  ///< Ordered by time, no time twice; at least one.
  ReferenceCounts counts;
  std::vector<std::string> notes;  ///< What the user should know, one line each.
};

struct ReferenceSource {
  ReferenceFormat format = ReferenceFormat::kNmea;
  std::filesystem::path path;
  std::optional<Geodetic> origin;  ///< Of the map frame; needed for kEuroc, whose metres are about this place.
  std::int64_t near_time_ns = 0;   ///< When the recording was made: the date of an NMEA log that has none.
};

/// Reads a reference. Of logs of receivers (kNmea, kGpx), damaged records are left out and counted; tables (the other
/// formats) must be whole. Errors, with the file and, of tables, the line: kNotFound, kBadFormat (also: no fix at all),
/// kIo, kInvalidArgument (an origin is missing or not valid).
[[nodiscard]] Result<Reference> read_reference(const ReferenceSource& source);

}  // namespace kinetrace::geo
