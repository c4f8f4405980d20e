#include <cstdint>
#include <limits>

#include "kinetrace/core/text_rows.hpp"
#include "reference_readers.hpp"

namespace kinetrace::geo {
namespace {

// Accuracies below a millimetre are not credible; beyond a kilometre a fix is useless.
constexpr double kMinSigma_m = 1e-3;
constexpr double kMaxSigma_m = 1e3;
// The difference of any two still fits into 64 bits.
constexpr std::int64_t kMaxTime_ns = std::numeric_limits<std::int64_t>::max() / 2;
// Limit of a local frame.
constexpr double kMaxCoordinate_m = 1e6;
// Motion capture or a laser tracker, with nearly isotropic errors.
constexpr double kTrackerSigma_m = 0.01;

}  // namespace

Result<std::vector<Fix>> read_euroc(const std::filesystem::path& path) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kComma);
  if (!rows) {
    return Unexpected(rows.error());
  }
  std::vector<Fix> fixes;
  while (rows->next()) {
    Fix fix;
    fix.time_ns = rows->time_ns(0);
    fix.enu_m = {rows->number(1), rows->number(2), rows->number(3)};
    fix.sigma_m.setConstant(kTrackerSigma_m);
    if (fix.enu_m.cwiseAbs().maxCoeff() > kMaxCoordinate_m) {
      rows->reject("more than 1000 km from the origin; expected metres");
    }
    fixes.push_back(fix);
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  return fixes;
}

Result<FileFixes> read_csv(const std::filesystem::path& path) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kComma);
  if (!rows) {
    return Unexpected(rows.error());
  }
  constexpr std::size_t kRequired = 4;
  const std::vector<std::size_t> columns = rows->columns(
      {"timestamp_ns", "latitude", "longitude", "height", "sigma_east", "sigma_north", "sigma_up"}, kRequired);
  FileFixes file;
  while (rows->next()) {
    FileFix fix;
    fix.time_ns = rows->integer(columns[0]);
    if (fix.time_ns < -kMaxTime_ns || fix.time_ns > kMaxTime_ns) {
      rows->reject("the time is beyond 146 years from 1970; expected nanoseconds");
    }
    fix.place = {rows->number(columns[1]), rows->number(columns[2]), rows->number(columns[3])};
    fix.sigma_m = kUsualSigma_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (const std::size_t column = columns[kRequired + axis]; column != TextRows::kNoColumn) {
        const double sigma_m = rows->number(column);
        fix.sigma_m[static_cast<Eigen::Index>(axis)] = sigma_m;
        if (!(sigma_m >= kMinSigma_m && sigma_m <= kMaxSigma_m)) {
          rows->reject("a standard deviation is outside of 0.001 to 1000 m");
        }
      }
    }
    if (!is_valid(fix.place)) {
      rows->reject("latitude, longitude and height are no place on Earth");
    }
    file.fixes.push_back(fix);
    ++file.counts.records;
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  return file;
}

}  // namespace kinetrace::geo
