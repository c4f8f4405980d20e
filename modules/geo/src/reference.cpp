#include "kinetrace/geo/reference.hpp"

#include <cmath>

#include "kinetrace/core/quantiles.hpp"
#include "reference_path.hpp"
#include "reference_readers.hpp"

namespace kinetrace::geo {
namespace {

Result<FileFixes> read_file(const ReferenceSource& source) {
  switch (source.format) {
    case ReferenceFormat::kOxts: return read_oxts(source.path);
    case ReferenceFormat::kNmea: return read_nmea(source.path, source.near_time_ns);
    case ReferenceFormat::kGpx: return read_gpx(source.path);
    case ReferenceFormat::kCsv: return read_csv(source.path);
    case ReferenceFormat::kEuroc: break;
  }
  return fail(ErrorCode::kInternal, "a reference without a reader");
}

/// Explanation for a file without a fix.
std::string why_none(const Reference& reference) {
  const ReferenceCounts& counts = reference.counts;
  std::string why = std::to_string(counts.records) + " records, of which " + std::to_string(counts.malformed) +
                    " are malformed, " + std::to_string(counts.bad_checksums) + " have a bad checksum and " +
                    std::to_string(counts.without_fix) + " say that there is no fix";
  for (const std::string& note : reference.notes) {
    why += "; " + note;
  }
  return why;
}

/// The median of each coordinate, robust to outliers; 0 without fixes.
Geodetic middle_of(const std::vector<FileFix>& fixes) {
  Geodetic middle;
  for (double Geodetic::*const coordinate : {&Geodetic::latitude_deg, &Geodetic::longitude_deg, &Geodetic::height_m}) {
    std::vector<double> values;
    values.reserve(fixes.size());
    for (const FileFix& fix : fixes) {
      values.push_back(fix.place.*coordinate);
    }
    middle.*coordinate = values.empty() ? 0.0 : median(values);
  }
  return middle;
}

Result<Reference> read_local(const ReferenceSource& source) {
  if (!source.origin) {
    return fail(ErrorCode::kInvalidArgument,
                source.path.string() + ": a reference in metres needs its origin on the Earth (--origin)");
  }
  Result<LocalFrame> frame = LocalFrame::at(*source.origin);
  if (!frame) {
    return Unexpected(frame.error());
  }
  Result<std::vector<Fix>> fixes = read_euroc(source.path);
  if (!fixes) {
    return Unexpected(fixes.error());
  }
  ReferenceCounts counts;
  counts.records = static_cast<std::int64_t>(fixes->size());
  return Reference{*frame, std::move(*fixes), counts, {}};
}

Result<Reference> read_global(const ReferenceSource& source) {
  Result<FileFixes> file = read_file(source);
  if (!file) {
    return Unexpected(file.error());
  }
  const Geodetic middle = middle_of(file->fixes);
  Result<LocalFrame> frame = LocalFrame::at(source.origin.value_or(middle));
  if (!frame) {
    return Unexpected(frame.error());
  }
  if (const Status near = file->fixes.empty() ? Status{} : check_origin(*frame, middle); !near) {
    return fail(near.error().code, source.path.string() + ": " + near.error().message);
  }
  Reference reference{*frame, {}, file->counts, std::move(file->notes)};
  for (const FileFix& fix : file->fixes) {
    reference.fixes.push_back({fix.time_ns, reference.frame.to_enu(fix.place), fix.sigma_m});
  }
  return reference;
}

}  // namespace

std::string_view to_string(ReferenceFormat format) noexcept {
  for (const auto& [name, value] : kReferenceFormats) {
    if (value == format) {
      return name;
    }
  }
  return "unknown";
}

Status check_origin(const LocalFrame& frame, const Geodetic& place) {
  constexpr double kMaxFromOrigin_m = 1e5;  // The vertical differs by 0.9 degrees.
  const double away_m = frame.to_enu(place).norm();
  if (away_m <= kMaxFromOrigin_m) {
    return {};
  }
  return fail(ErrorCode::kInvalidArgument,
              "--origin lies " + std::to_string(std::lround(away_m / 1000.0)) +
                  " km from the fixes: up is another direction there; give one within 100 km, or none");
}

Result<Reference> read_reference(const ReferenceSource& source) {
  Result<Reference> reference = source.format == ReferenceFormat::kEuroc ? read_local(source) : read_global(source);
  if (!reference) {
    return reference;
  }
  if (reference->fixes.empty()) {
    return fail(ErrorCode::kBadFormat, source.path.string() + ": no fix of format " +
                                           std::string(to_string(source.format)) + " in it: " + why_none(*reference));
  }
  make_path(reference->fixes, reference->counts);
  return reference;
}

}  // namespace kinetrace::geo
