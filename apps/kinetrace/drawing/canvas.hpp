// A picture to draw on: smooth lines, areas, images and text, written as PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "color.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::drawing {

/// Pixels, x right, y down. The first pixel covers [0, 1) x [0, 1): its centre is (0.5, 0.5).
using Point = Eigen::Vector2d;

struct Rect {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;

  [[nodiscard]] double right() const noexcept { return x + width; }
  [[nodiscard]] double bottom() const noexcept { return y + height; }
  [[nodiscard]] Point center() const { return {x + width / 2, y + height / 2}; }
  [[nodiscard]] bool contains(const Point& p) const {
    return p.x() >= x && p.y() >= y && p.x() < right() && p.y() < bottom();
  }
  [[nodiscard]] bool overlaps(const Rect& other) const noexcept {
    return x < other.right() && other.x < right() && y < other.bottom() && other.y < bottom();
  }
  /// Each side moved outwards by `margin`; inwards if it is negative.
  [[nodiscard]] Rect grown(double margin) const noexcept {
    return {x - margin, y - margin, width + 2 * margin, height + 2 * margin};
  }
};

struct Stroke {
  Color color = kInk;
  double width_px = 1.5;
  Dash dash = Dash::kSolid;
  double alpha = 1.0;
};

enum class HorizontalAnchor : std::uint8_t { kLeft, kCenter, kRight };
enum class VerticalAnchor : std::uint8_t { kTop, kMiddle, kBaseline };

/// Style and anchor of a text. ASCII only; other characters become '?'.
struct TextStyle {
  double size_px = 10.0;  ///< Height of capital letters.
  Color color = kInk;
  bool bold = false;
  HorizontalAnchor horizontal = HorizontalAnchor::kLeft;
  VerticalAnchor vertical = VerticalAnchor::kBaseline;
  double halo_px = 0.0;  ///< Width of an outline in `halo`, for contrast with the ground.
  Color halo = kPaper;
  bool upwards = false;  ///< Turned by 90 degrees, to be read from the right; the anchors turn with it.
};

/// Width of the text in pixels.
[[nodiscard]] double text_width(std::string_view text, const TextStyle& style);
/// `text`, truncated with ".." to at most `width_px`.
[[nodiscard]] std::string shortened(std::string_view text, double width_px, const TextStyle& style);

/// Antialiased by the coverage of each pixel (4 x 4 samples), so that lines of any width are smooth. Points that are
/// not finite interrupt a line; everything outside the clip is left out.
class Canvas {
 public:
  Canvas(int width_px, int height_px, Color background);

  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  [[nodiscard]] ImageView<const Color> view() const noexcept { return {pixels_.data(), width_, height_, width_}; }
  [[nodiscard]] Color at(int x, int y) const { return view().at(x, y); }

  /// From now on only pixels within `rect` change; whole pixels.
  void clip(const Rect& rect);
  void unclip();

  void line(const Point& a, const Point& b, const Stroke& stroke);
  void polyline(std::span<const Point> points, const Stroke& stroke);
  /// Draws lines as one shape: opacity does not add up at crossings. Empty lines are allowed.
  void polylines(std::span<const std::vector<Point>> lines, const Stroke& stroke);
  void polygon(std::span<const Point> corners, Color color, double alpha = 1.0);
  void rectangle(const Rect& rect, Color color, double alpha = 1.0);
  void outline(const Rect& rect, const Stroke& stroke);
  void disk(const Point& center, double radius_px, Color color, double alpha = 1.0);

  void text(const Point& anchor, std::string_view text, const TextStyle& style);

  /// A gray image, scaled to fill `rect`, blended with the share `fade` of white.
  void image(GrayView image, const Rect& rect, double fade = 0.0);
  /// Fills the pixels where `mask` (an image that fills `rect`) is not zero.
  void mask(GrayView mask, const Rect& rect, Color color, double alpha);
  /// Draws the border of that area.
  void mask_outline(GrayView mask, const Rect& rect, const Stroke& stroke);

  /// Errors: kIo.
  [[nodiscard]] Status write_png(const std::filesystem::path& path,
                                 imaging::PngEffort effort = imaging::PngEffort::kSmall) const;

 private:
  [[nodiscard]] PixelBox visible(const Rect& rect) const;
  void blend(const PixelBox& box, GrayView coverage, Color color, double alpha);
  void blend_pixel(int x, int y, Color color, double share);

  int width_;
  int height_;
  std::vector<Color> pixels_;
  PixelBox clip_;
};

}  // namespace kinetrace::drawing
