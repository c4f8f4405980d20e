// Text in the Hershey font of OpenCV, drawn large and averaged down, so that strokes are smooth at any size.
#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "canvas.hpp"

namespace kinetrace::drawing {
namespace {

constexpr int kFine = 4;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapitals = 21.0;  ///< Height of capital letters at scale 1.
constexpr double kDescent = 0.4;    ///< Below the base line, in heights of capitals.
constexpr double kRegular = 0.125;  ///< Width of strokes, in heights of capitals.
constexpr double kBold = 0.21;

struct Font {
  double scale = 1.0;
  int stroke = 1;  ///< Samples.
};

Font font_of(const TextStyle& style) {
  const double size = std::max(style.size_px, 1.0) * kFine;
  return {size / kCapitals, std::max(1, static_cast<int>(std::lround(size * (style.bold ? kBold : kRegular))))};
}

std::string printable(std::string_view text) {
  std::string plain;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    // Continuation bytes belong to a character that has its '?' already.
    if (byte >= 0x20 && byte < 0x7f) {
      plain.push_back(c);
    } else if ((byte & 0xc0U) != 0x80U) {
      plain.push_back('?');
    }
  }
  return plain;
}

double horizontal_shift(const TextStyle& style, double width) {
  switch (style.horizontal) {
    case HorizontalAnchor::kLeft: return 0.0;
    case HorizontalAnchor::kCenter: return -width / 2;
    case HorizontalAnchor::kRight: return -width;
  }
  return 0.0;
}

/// From the anchor down to the base line.
double baseline_shift(const TextStyle& style) {
  switch (style.vertical) {
    case VerticalAnchor::kTop: return style.size_px;
    case VerticalAnchor::kMiddle: return style.size_px / 2;
    case VerticalAnchor::kBaseline: return 0.0;
  }
  return 0.0;
}

}  // namespace

double text_width(std::string_view text, const TextStyle& style) {
  const Font font = font_of(style);
  return cv::getTextSize(printable(text), kFont, font.scale, font.stroke, nullptr).width / static_cast<double>(kFine);
}

std::string shortened(std::string_view text, double width_px, const TextStyle& style) {
  if (text_width(text, style) <= width_px) {
    return std::string(text);
  }
  std::string kept(text);
  while (!kept.empty() && text_width(kept + "..", style) > width_px) {
    kept.pop_back();
  }
  return kept + "..";
}

void Canvas::text(const Point& anchor, std::string_view text, const TextStyle& style) {
  const std::string plain = printable(text);
  if (plain.empty() || !anchor.allFinite()) {
    return;
  }
  const Font font = font_of(style);
  const double width = text_width(plain, style);
  const double margin = style.halo_px + 2.0;
  // Start of the text's base line on the canvas; rotated text runs towards smaller y.
  const double along = horizontal_shift(style, width);
  const double across = baseline_shift(style);
  const Point base =
      style.upwards ? Point(anchor.x() + across, anchor.y() - along) : Point(anchor.x() + along, anchor.y() + across);
  const double above = style.size_px + margin;
  const double below = style.size_px * kDescent + margin;
  const Rect place = style.upwards
                         ? Rect{base.x() - above, base.y() - width - margin, above + below, width + 2 * margin}
                         : Rect{base.x() - margin, base.y() - above, width + 2 * margin, above + below};
  const PixelBox box = visible(place);
  const PixelBox whole{static_cast<int>(std::floor(place.x)), static_cast<int>(std::floor(place.y)),
                       static_cast<int>(std::ceil(place.right())), static_cast<int>(std::ceil(place.bottom()))};
  if (box.empty()) {
    return;
  }
  const auto draw = [&](Color color, double extra_px) {
    const int length = style.upwards ? whole.height() : whole.width();
    const int height = style.upwards ? whole.width() : whole.height();
    cv::Mat1b fine(height * kFine, length * kFine, std::uint8_t{0});
    const Point start = style.upwards ? Point(whole.y1 - base.y(), base.x() - whole.x0)
                                      : Point(base.x() - whole.x0, base.y() - whole.y0);
    cv::putText(fine, plain,
                {static_cast<int>(std::lround(start.x() * kFine)), static_cast<int>(std::lround(start.y() * kFine))},
                kFont, font.scale, 255, font.stroke + static_cast<int>(std::lround(2 * extra_px * kFine)), cv::LINE_8);
    cv::Mat1b coverage;
    cv::resize(fine, coverage, {length, height}, 0, 0, cv::INTER_AREA);
    if (style.upwards) {
      cv::rotate(coverage, coverage, cv::ROTATE_90_COUNTERCLOCKWISE);
    }
    const cv::Mat1b seen = coverage({box.x0 - whole.x0, box.y0 - whole.y0, box.width(), box.height()});
    blend(box, {seen.data, seen.cols, seen.rows, static_cast<int>(seen.step)}, color, 1.0);
  };
  if (style.halo_px > 0.0) {
    draw(style.halo, style.halo_px);
  }
  draw(style.color, 0.0);
}

}  // namespace kinetrace::drawing
