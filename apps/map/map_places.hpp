// Where a map's files lie, and what they may replace.
#pragma once

#include <filesystem>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::map {

inline constexpr std::string_view kReport = "map.json";
inline constexpr std::string_view kPicture = "map.png";
inline constexpr std::string_view kGeoJson = "trajectories.geojson";
inline constexpr std::string_view kKml = "trajectories.kml";
inline constexpr std::string_view kGpx = "trajectories.gpx";
inline constexpr std::string_view kCsv = "trajectories.csv";

/// A map replaces an earlier map only: neither its own reference nor any other file, and nothing in the run's
/// recording. Errors: kOccupied.
[[nodiscard]] Status check_places(const std::filesystem::path& folder, const recording::Run& run,
                                  const std::filesystem::path& reference);

/// Removes trajectories and picture of an earlier alignment, which a refused one must not seem to confirm.
void remove_map(const std::filesystem::path& folder);

}  // namespace kinetrace::map
