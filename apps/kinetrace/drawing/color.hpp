// Colours distinguishable for colour-blind readers, and greys for everything else.
#pragma once

#include <cstdint>

#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::drawing {

using Color = imaging::Rgb8;

inline constexpr Color kPaper{255, 255, 255};  ///< Behind everything.
inline constexpr Color kPanel{247, 247, 245};  ///< Behind a drawing.
inline constexpr Color kGrid{226, 227, 225};
inline constexpr Color kFrame{190, 192, 191};
inline constexpr Color kMuted{104, 109, 114};  ///< Captions, ticks.
inline constexpr Color kInk{33, 36, 40};       ///< Text; the camera's path.
inline constexpr Color kRed{213, 94, 0};       ///< Vermillion: cameras around an object.

/// `share` of b, the rest a.
[[nodiscard]] constexpr Color mix(Color a, Color b, double share) noexcept {
  const int part = static_cast<int>(share * 256.0);
  const auto channel = [part](int x, int y) {
    return static_cast<std::uint8_t>((x * (256 - part) + y * part + 128) / 256);
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

enum class Dash : std::uint8_t { kSolid, kDashed, kDotted };

/// Drawing style of one item of a set, the same in all pictures.
struct LineStyle {
  Color color = kInk;
  Dash dash = Dash::kSolid;
};

/// Number of different styles; after that they repeat.
inline constexpr int kLineStyles = 18;

/// The style with this number. Six hues of Okabe and Ito ("Color Universal Design", 2008), which readers with any
/// common colour blindness tell apart; yellow is left out for its low contrast on white, black because the camera uses
/// it. Hue changes fastest; 6..11 are darker and dashed, 12..17 lighter and dotted.
[[nodiscard]] LineStyle line_style(int index) noexcept;

/// The style of a track: a function of its id alone, so that figure, overlay and every run agree.
[[nodiscard]] LineStyle track_style(std::uint32_t track_id) noexcept;

/// Black or white, whichever is easier to read on `background`.
[[nodiscard]] Color readable_on(Color background) noexcept;

}  // namespace kinetrace::drawing
