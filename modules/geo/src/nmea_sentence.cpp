#include "nmea_sentence.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "kinetrace/core/text_rows.hpp"

namespace kinetrace::geo {

Sentence parse_sentence(std::string_view line) {
  const std::size_t start = line.find('$');
  const std::size_t star = line.rfind('*');
  // Talker (two letters), type (three).
  constexpr std::size_t kAddress = 5;
  if (start == std::string_view::npos || star == std::string_view::npos || star < start + 1 + kAddress) {
    return {};
  }
  const std::string_view body = line.substr(start + 1, star - start - 1);
  const std::string_view digits = line.substr(star + 1, 2);
  unsigned expected = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), expected, 16);
  if (digits.size() != 2 || error != std::errc{} || end != digits.data() + 2) {
    return {};
  }
  unsigned sum = 0;
  for (const char c : body) {
    sum ^= static_cast<unsigned char>(c);
  }
  if (sum != expected) {
    return {.state = SentenceState::kBadChecksum};
  }
  Sentence sentence{SentenceState::kGood, body.substr(2, 3), {}};
  std::size_t at = kAddress;
  while (at < body.size() && body[at] == ',') {
    const std::size_t next = std::min(body.find(',', at + 1), body.size());
    sentence.fields.push_back(body.substr(at + 1, next - at - 1));
    at = next;
  }
  return sentence;
}

std::optional<double> parse_angle_deg(std::string_view value, std::string_view hemisphere) {
  const bool is_latitude = hemisphere == "N" || hemisphere == "S";
  const bool is_longitude = hemisphere == "E" || hemisphere == "W";
  const auto number = parse_number(value);
  if ((!is_latitude && !is_longitude) || !number || *number < 0.0) {
    return std::nullopt;
  }
  const double degrees = std::floor(*number / 100.0);
  const double minutes = *number - 100.0 * degrees;
  const double angle_deg = degrees + minutes / 60.0;
  if (minutes >= 60.0 || angle_deg > (is_latitude ? 90.0 : 180.0)) {
    return std::nullopt;
  }
  return hemisphere == "S" || hemisphere == "W" ? -angle_deg : angle_deg;
}

}  // namespace kinetrace::geo
