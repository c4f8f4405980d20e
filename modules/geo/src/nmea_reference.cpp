#include <algorithm>
#include <cmath>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "nmea_sentence.hpp"
#include "reference_readers.hpp"
#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

/// Standard deviation of ranges, by the quality field of GGA: autonomous, differential, carrier phase fixed and float.
double range_sigma_m(int quality) {
  switch (quality) {
    case 2: return 1.0;
    case 4: return 0.02;
    case 5: return 0.3;
    default: return kUsualSigma_m.x();
  }
}

/// Qualities without a measured position.
bool is_no_fix(int quality) {
  constexpr int kDeadReckoning = 6;
  return quality == 0 || quality >= kDeadReckoning;
}

/// Status of an RMC without a fix. Its date may be the one that the receiver's clock begins with.
constexpr std::string_view kVoid = "V";

class NmeaReader {
 public:
  explicit NmeaReader(std::int64_t near_time_ns) : near_time_ns_(near_time_ns) {}

  void take(std::string_view line) {
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) {
      return;
    }
    ++file_.counts.records;
    const Sentence sentence = parse_sentence(line);
    if (sentence.state == SentenceState::kBadChecksum) {
      ++file_.counts.bad_checksums;
    } else if (sentence.state == SentenceState::kMalformed) {
      ++file_.counts.malformed;
    } else if (sentence.type == "GGA") {
      has_positions_ = true;
      take_position(sentence.fields);
    } else if (sentence.type == "RMC" && sentence.fields.size() > 8 && sentence.fields[1] != kVoid) {
      take_date(sentence.fields[0], sentence.fields[8]);
    } else if (sentence.type == "ZDA" && sentence.fields.size() > 3) {
      take_long_date(sentence.fields);
    }
  }

  FileFixes finish() {
    if (!dated_ && !file_.fixes.empty()) {
      file_.notes.emplace_back("the log has no date (RMC or ZDA): that of the recording is taken");
    }
    if (!has_positions_ && file_.counts.records > 0) {
      file_.notes.emplace_back(
          "the log has no readable GGA, whose positions alone have heights: have the receiver send it");
    }
    // Positions before the first date.
    const std::int64_t midnight_ns = undated_ > 0 ? first_day_ns() : 0;
    for (std::size_t i = 0; i < undated_; ++i) {
      file_.fixes[i].time_ns += midnight_ns;
    }
    return std::move(file_);
  }

 private:
  void take_position(const std::vector<std::string_view>& fields) {
    constexpr std::size_t kFields = 11;
    const auto quality = fields.size() < kFields ? std::nullopt : parse_integer(fields[5]);
    if (!quality || *quality < 0 || *quality > 9) {
      ++file_.counts.malformed;
      return;
    }
    if (is_no_fix(static_cast<int>(*quality))) {
      ++file_.counts.without_fix;
      return;
    }
    const auto clock_ns = time_of_day_ns(fields[0]);
    const auto latitude = parse_angle_deg(fields[1], fields[2]);
    const auto longitude = parse_angle_deg(fields[3], fields[4]);
    const auto altitude = parse_number(fields[8]);
    if (!clock_ns || !latitude || !longitude || !altitude) {
      ++file_.counts.malformed;
      return;
    }
    // Above sea level; the geoid's height above the ellipsoid converts it.
    const double geoid_m = parse_number(fields[10]).value_or(0.0);
    FileFix fix{0, {*latitude, *longitude, *altitude + geoid_m}, usual_sigma_m(static_cast<int>(*quality), fields[7])};
    if (!is_valid(fix.place)) {
      ++file_.counts.malformed;
      return;
    }
    fix.time_ns = day_of(*clock_ns) + *clock_ns;
    file_.fixes.push_back(fix);
    undated_ = dated_ ? undated_ : file_.fixes.size();
  }

  static Eigen::Vector3d usual_sigma_m(int quality, std::string_view hdop) {
    constexpr double kMaxDilution = 50.0;
    const double dilution = std::clamp(parse_number(hdop).value_or(1.0), 0.5, kMaxDilution);
    return dilution * range_sigma_m(quality) / kUsualSigma_m.x() * kUsualSigma_m;
  }

  /// A sentence's date may come before or after the position of the same second: a clock that goes back by hours has
  /// passed midnight.
  std::int64_t day_of(std::int64_t clock_ns) {
    if (clock_ns < last_clock_ns_ - kDay_ns / 2) {
      day_ns_ += kDay_ns;
    }
    last_clock_ns_ = clock_ns;
    return day_ns_;
  }

  void take_date(std::string_view clock, std::string_view date) {
    const auto number = date.size() == 6 ? parse_integer(date) : std::nullopt;
    if (!number || *number < 0) {
      return;
    }
    constexpr int kCentury = 2000;
    const auto day = static_cast<int>(*number / 10'000);
    const auto month = static_cast<int>(*number / 100 % 100);
    set_day(time_of_day_ns(clock), day_start_ns(kCentury + static_cast<int>(*number % 100), month, day));
  }

  void take_long_date(const std::vector<std::string_view>& fields) {
    const auto day = parse_integer(fields[1]);
    const auto month = parse_integer(fields[2]);
    const auto year = parse_integer(fields[3]);
    const auto is_small = [](const auto& number) { return number && *number >= 0 && *number <= 9999; };
    if (is_small(day) && is_small(month) && is_small(year)) {
      set_day(time_of_day_ns(fields[0]),
              day_start_ns(static_cast<int>(*year), static_cast<int>(*month), static_cast<int>(*day)));
    }
  }

  void set_day(std::optional<std::int64_t> clock_ns, std::optional<std::int64_t> day_ns) {
    if (!clock_ns || !day_ns) {
      return;
    }
    if (!dated_) {
      // Days before the first date.
      first_day_ns_ = *day_ns - day_of(*clock_ns);
      dated_ = true;
    }
    day_ns_ = *day_ns;
    last_clock_ns_ = *clock_ns;
  }

  [[nodiscard]] std::int64_t first_day_ns() const {
    if (dated_) {
      return first_day_ns_;
    }
    const auto days =
        std::llround(static_cast<double>(near_time_ns_ - file_.fixes.front().time_ns) / static_cast<double>(kDay_ns));
    return days * kDay_ns;
  }

  FileFixes file_;
  std::int64_t near_time_ns_;
  bool has_positions_ = false;
  bool dated_ = false;
  std::size_t undated_ = 0;  ///< This many of the first fixes count from midnight of the log's first day.
  std::int64_t first_day_ns_ = 0;
  std::int64_t day_ns_ = 0;
  std::int64_t last_clock_ns_ = 0;
};

}  // namespace

Result<FileFixes> read_nmea(const std::filesystem::path& path, std::int64_t near_time_ns) {
  const Result<std::string> text = InputFile::read_whole(path);
  if (!text) {
    return Unexpected(text.error());
  }
  NmeaReader reader(near_time_ns);
  std::string_view rest = *text;
  while (!rest.empty()) {
    const std::size_t length = std::min(rest.find('\n'), rest.size());
    reader.take(rest.substr(0, length));
    rest.remove_prefix(std::min(length + 1, rest.size()));
  }
  return reader.finish();
}

}  // namespace kinetrace::geo
