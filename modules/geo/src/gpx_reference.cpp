#include <pugixml.hpp>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "reference_readers.hpp"
#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

std::optional<double> number(const char* text) {
  return parse_number(text);
}

/// None if time, position or height is missing or invalid.
std::optional<FileFix> parse_point(const pugi::xml_node& point) {
  const auto time_ns = parse_date_time_ns(point.child_value("time"));
  const auto latitude = number(point.attribute("lat").value());
  const auto longitude = number(point.attribute("lon").value());
  const auto elevation = number(point.child_value("ele"));
  if (!time_ns || !latitude || !longitude || !elevation) {
    return std::nullopt;
  }
  // GPX does not define the elevation's datum; only with a geoid height it is certainly above sea level.
  const double geoid_m = number(point.child_value("geoidheight")).value_or(0.0);
  FileFix fix{*time_ns, {*latitude, *longitude, *elevation + geoid_m}, kUsualSigma_m};
  if (const auto dilution = number(point.child_value("hdop")); dilution && *dilution >= 0.5 && *dilution <= 50.0) {
    fix.sigma_m *= *dilution;
  }
  return is_valid(fix.place) ? std::optional(fix) : std::nullopt;
}

void note_missing(const char* element, std::int64_t points, FileFixes& file) {
  if (points > 0) {
    file.notes.push_back(std::to_string(points) + " of " + std::to_string(file.counts.records) + " points have no <" +
                         element + "> and are left out; export the track with it");
  }
}

}  // namespace

Result<FileFixes> read_gpx(const std::filesystem::path& path) {
  const Result<std::string> text = InputFile::read_whole(path);
  if (!text) {
    return Unexpected(text.error());
  }
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text->data(), text->size());
  if (!parsed) {
    return fail(ErrorCode::kBadFormat,
                path.string() + ": no GPX file: " + parsed.description() + " at byte " + std::to_string(parsed.offset));
  }
  FileFixes file;
  std::int64_t without_time = 0;
  std::int64_t without_height = 0;
  for (const pugi::xml_node& track : document.child("gpx").children("trk")) {
    for (const pugi::xml_node& segment : track.children("trkseg")) {
      for (const pugi::xml_node& point : segment.children("trkpt")) {
        ++file.counts.records;
        without_time += point.child("time") ? 0 : 1;
        without_height += point.child("ele") ? 0 : 1;
        if (const auto fix = parse_point(point)) {
          file.fixes.push_back(*fix);
        } else {
          ++file.counts.malformed;
        }
      }
    }
  }
  note_missing("time", without_time, file);
  note_missing("ele", without_height, file);
  return file;
}

}  // namespace kinetrace::geo
