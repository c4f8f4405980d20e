#include "color.hpp"

#include <array>

namespace kinetrace::drawing {
namespace {

constexpr std::array<Color, 6> kHues{{
    {0, 114, 178},    // Blue
    {230, 159, 0},    // Orange
    {0, 158, 115},    // Bluish green
    {204, 121, 167},  // Reddish purple
    {86, 180, 233},   // Sky blue
    {213, 94, 0},     // Vermillion
}};
constexpr std::array<Dash, 3> kDashes{Dash::kSolid, Dash::kDashed, Dash::kDotted};
static_assert(kHues.size() * kDashes.size() == kLineStyles);

}  // namespace

LineStyle line_style(int index) noexcept {
  const int wrapped = (index % kLineStyles + kLineStyles) % kLineStyles;
  const auto hue = static_cast<std::size_t>(wrapped) % kHues.size();
  const auto turn = static_cast<std::size_t>(wrapped) / kHues.size();
  constexpr double kDarker = 0.32;
  constexpr double kLighter = 0.3;
  Color color = kHues[hue];
  if (turn == 1) {
    color = mix(color, Color{0, 0, 0}, kDarker);
  } else if (turn == 2) {
    color = mix(color, Color{255, 255, 255}, kLighter);
  }
  return {color, kDashes[turn]};
}

LineStyle track_style(std::uint32_t track_id) noexcept {
  // Ids begin at 1.
  return line_style(static_cast<int>((track_id + kLineStyles - 1) % kLineStyles));
}

Color readable_on(Color background) noexcept {
  const int luma = 299 * background.r + 587 * background.g + 114 * background.b;
  return luma > 150'000 ? kInk : Color{255, 255, 255};
}

}  // namespace kinetrace::drawing
