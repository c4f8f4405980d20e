#include <cstdio>
#include <system_error>

#include "kinetrace/core/files.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "reference_readers.hpp"
#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

namespace fs = std::filesystem;

// Columns of KITTI's dataformat.txt.
constexpr std::size_t kFields = 30;
constexpr std::size_t kAccuracyField = 23;
// Lower bound for receivers on vehicles.
constexpr double kMinSigma_m = 0.01;
constexpr double kMaxSigma_m = 1e3;

Result<std::vector<std::int64_t>> read_times(const fs::path& path) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kBlanks);
  if (!rows) {
    return Unexpected(rows.error());
  }
  rows->expect_fields(2);
  std::vector<std::int64_t> times;
  while (rows->next()) {
    const std::string text = std::string(rows->text(0)) + ' ' + std::string(rows->text(1));
    const auto time_ns = parse_date_time_ns(text);
    if (!time_ns) {
      rows->reject("expected a time as 2011-09-26 13:02:25.594");
      break;
    }
    times.push_back(*time_ns);
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  return times;
}

Result<FileFix> read_fix(const fs::path& path, std::int64_t time_ns) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kBlanks);
  if (!rows) {
    return Unexpected(rows.error());
  }
  rows->expect_fields(kFields);
  FileFix fix;
  fix.time_ns = time_ns;
  if (rows->next()) {
    fix.place = {rows->number(0), rows->number(1), rows->number(2)};
    const double accuracy_m = rows->number(kAccuracyField);
    fix.sigma_m.setConstant(std::min(std::max(accuracy_m, kMinSigma_m), kMaxSigma_m));
    if (!is_valid(fix.place)) {
      rows->reject("latitude, longitude and height are no place on Earth");
    }
  } else {
    rows->reject("expected a row of 30 numbers, found none");
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  return fix;
}

}  // namespace

Result<FileFixes> read_oxts(const fs::path& path) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path / "oxts", error) ? path / "oxts" : path;
  if (const Status there = check_folder(folder, "no such folder; give a drive of KITTI raw, or its folder oxts");
      !there) {
    return Unexpected(there.error());
  }
  const Result<std::vector<std::int64_t>> times = read_times(folder / "timestamps.txt");
  if (!times) {
    return Unexpected(times.error());
  }
  FileFixes file;
  for (std::size_t i = 0; i < times->size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%010zu.txt", i);
    const Result<FileFix> fix = read_fix(folder / "data" / name, (*times)[i]);
    if (!fix) {
      return Unexpected(fix.error());
    }
    file.fixes.push_back(*fix);
  }
  file.counts.records = static_cast<std::int64_t>(times->size());
  return file;
}

}  // namespace kinetrace::geo
