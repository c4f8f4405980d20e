// One line of NMEA 0183.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kinetrace::geo {

enum class SentenceState : std::uint8_t { kGood, kBadChecksum, kMalformed };

struct Sentence {
  SentenceState state = SentenceState::kMalformed;
  std::string_view type = {};                 ///< "GGA", "RMC", from any talker.
  std::vector<std::string_view> fields = {};  ///< After the type.
};

/// `$GPGGA,...*hh`, whatever precedes the `$`. A sentence without a checksum counts as malformed: on a serial line,
/// nothing else detects errors.
[[nodiscard]] Sentence parse_sentence(std::string_view line);

/// `ddmm.mmmm` or `dddmm.mmmm` with N, S, E or W; none if invalid.
[[nodiscard]] std::optional<double> parse_angle_deg(std::string_view value, std::string_view hemisphere);

}  // namespace kinetrace::geo
