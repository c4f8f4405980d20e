#include "map_places.hpp"

#include <array>
#include <string>
#include <system_error>

#include "kinetrace/core/files.hpp"
#include "kinetrace/geo/map_files.hpp"
#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::map {
namespace {

namespace fs = std::filesystem;

struct MapFile {
  std::string_view name;
  FileKind kind;
};
constexpr std::array<MapFile, 6> kFiles{{
    {kReport, {"report of a map", [](const fs::path& path) { return begins_with(path, "{\n  \"verdict\": "); }}},
    {kPicture, {"picture of a map", &imaging::is_drawn_picture}},
    {kGeoJson, {"file of a map", [](const fs::path& path) { return begins_with(path, geo::kGeoJsonBegin); }}},
    {kKml, {"file of a map", [](const fs::path& path) { return begins_with(path, geo::kKmlBegin); }}},
    {kGpx, {"file of a map", [](const fs::path& path) { return begins_with(path, geo::kGpxBegin); }}},
    {kCsv, {"file of a map", [](const fs::path& path) { return begins_with(path, geo::kCsvBegin); }}},
}};

/// The folder of a dataset may hold runs, too.
bool is_in_recording(const fs::path& folder, const recording::Run& run) {
  const fs::path recording = run.dataset.substr(run.dataset.find(':') + 1);
  return !recording.empty() && is_inside(folder, recording) && !is_inside(folder, run.directory);
}

}  // namespace

Status check_places(const fs::path& folder, const recording::Run& run, const fs::path& reference) {
  if (is_in_recording(folder, run)) {
    return fail(ErrorCode::kOccupied,
                folder.string() + ": lies in the recording " + run.dataset + "; name another folder for the map");
  }
  for (const MapFile& file : kFiles) {
    const fs::path place = folder / file.name;
    std::error_code error;
    if (fs::equivalent(place, reference, error)) {
      return fail(ErrorCode::kOccupied,
                  reference.string() + ": is the reference, which the map would replace; name another folder --out");
    }
    if (Status free = check_same_kind(place, file.kind); !free) {
      return free;
    }
  }
  return {};
}

void remove_map(const fs::path& folder) {
  for (const MapFile& file : kFiles) {
    const fs::path place = folder / file.name;
    std::error_code ignored;
    if (file.name != kReport && file.kind.is_of_kind(place)) {
      fs::remove(place, ignored);
    }
  }
}

}  // namespace kinetrace::map
