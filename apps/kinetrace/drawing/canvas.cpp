#include "canvas.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "dashes.hpp"

namespace kinetrace::drawing {
namespace {

// Samples per pixel and direction; fractional bits of OpenCV's coordinates below that.
constexpr int kFine = 4;
constexpr int kShift = 3;
constexpr int kUnit = 1 << kShift;

cv::Mat as_mat(GrayView image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
          static_cast<std::size_t>(image.stride)};
}

/// Coverage samples of a part of the canvas.
class Samples {
 public:
  explicit Samples(const PixelBox& box)
      : box_(box), fine_(box.height() * kFine, box.width() * kFine, std::uint8_t{0}) {}

  [[nodiscard]] cv::Mat1b& mat() noexcept { return fine_; }
  /// In fixed point, relative to the centre of the first sample.
  [[nodiscard]] cv::Point fixed(const Point& p) const {
    const auto coordinate = [](double value, int origin) {
      return static_cast<int>(std::lround(((value - origin) * kFine - 0.5) * kUnit));
    };
    return {coordinate(p.x(), box_.x0), coordinate(p.y(), box_.y0)};
  }
  /// 255 where every sample of a pixel is set.
  [[nodiscard]] cv::Mat1b coverage() const {
    cv::Mat1b coverage;
    cv::resize(fine_, coverage, {box_.width(), box_.height()}, 0, 0, cv::INTER_AREA);
    return coverage;
  }

 private:
  PixelBox box_;
  cv::Mat1b fine_;
};

GrayView as_view(const cv::Mat1b& mat) {
  return {mat.data, mat.cols, mat.rows, static_cast<int>(mat.step)};
}

Rect bounds_of(std::span<const Segment> segments) {
  Point low = segments.front().a;
  Point high = low;
  for (const Segment& segment : segments) {
    low = low.cwiseMin(segment.a).cwiseMin(segment.b);
    high = high.cwiseMax(segment.a).cwiseMax(segment.b);
  }
  return {low.x(), low.y(), high.x() - low.x(), high.y() - low.y()};
}

cv::Mat1b to_coverage(GrayView mask, const Rect& rect, const PixelBox& box) {
  // The mask's pixels on the canvas: scaling and shift, in OpenCV's convention of integer centres.
  const double sx = rect.width / mask.width;
  const double sy = rect.height / mask.height;
  cv::Mat1b set;
  cv::compare(as_mat(mask), 0, set, cv::CMP_NE);
  if (sx < 1.0 || sy < 1.0) {
    cv::resize(set, set,
               {std::max(1, static_cast<int>(std::lround(rect.width))),
                std::max(1, static_cast<int>(std::lround(rect.height)))},
               0, 0, cv::INTER_AREA);
  }
  const double fx = rect.width / set.cols;
  const double fy = rect.height / set.rows;
  const cv::Matx23d place(fx, 0, rect.x + 0.5 * fx - 0.5 - box.x0, 0, fy, rect.y + 0.5 * fy - 0.5 - box.y0);
  cv::Mat1b coverage;
  cv::warpAffine(set, coverage, place, {box.width(), box.height()}, cv::INTER_LINEAR);
  return coverage;
}

}  // namespace

Canvas::Canvas(int width_px, int height_px, Color background)
    : width_(width_px),
      height_(height_px),
      pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), background),
      clip_{0, 0, width_px, height_px} {}

PixelBox Canvas::visible(const Rect& rect) const {
  const auto whole = [](double value) {
    constexpr double kFar = 1e6;
    return static_cast<int>(std::clamp(value, -kFar, kFar));
  };
  return {std::max(clip_.x0, whole(std::floor(rect.x))), std::max(clip_.y0, whole(std::floor(rect.y))),
          std::min(clip_.x1, whole(std::ceil(rect.right()))), std::min(clip_.y1, whole(std::ceil(rect.bottom())))};
}

void Canvas::clip(const Rect& rect) {
  unclip();
  clip_ = visible(rect);
}

void Canvas::unclip() {
  clip_ = {0, 0, width_, height_};
}

void Canvas::blend_pixel(int x, int y, Color color, double share) {
  Color& pixel = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  pixel = mix(pixel, color, share);
}

void Canvas::blend(const PixelBox& box, GrayView coverage, Color color, double alpha) {
  for (int y = 0; y < box.height(); ++y) {
    const std::uint8_t* row = coverage.row(y);
    for (int x = 0; x < box.width(); ++x) {
      if (row[x] != 0) {
        blend_pixel(box.x0 + x, box.y0 + y, color, alpha * row[x] / 255.0);
      }
    }
  }
}

void Canvas::line(const Point& a, const Point& b, const Stroke& stroke) {
  polyline(std::vector<Point>{a, b}, stroke);
}

void Canvas::polyline(std::span<const Point> points, const Stroke& stroke) {
  const std::vector<std::vector<Point>> lines{{points.begin(), points.end()}};
  polylines(lines, stroke);
}

void Canvas::polylines(std::span<const std::vector<Point>> lines, const Stroke& stroke) {
  const double margin = stroke.width_px + 1.0;
  const Rect clip{static_cast<double>(clip_.x0), static_cast<double>(clip_.y0), static_cast<double>(clip_.width()),
                  static_cast<double>(clip_.height())};
  std::vector<Segment> segments;
  for (const std::vector<Point>& points : lines) {
    append_dashes(points, clip.grown(margin), stroke.dash, stroke.width_px, segments);
  }
  if (segments.empty()) {
    return;
  }
  const PixelBox box = visible(bounds_of(segments).grown(margin));
  if (box.empty()) {
    return;
  }
  Samples samples(box);
  const int thickness = std::max(1, static_cast<int>(std::lround(stroke.width_px * kFine)));
  for (const Segment& segment : segments) {
    cv::line(samples.mat(), samples.fixed(segment.a), samples.fixed(segment.b), 255, thickness, cv::LINE_8, kShift);
  }
  blend(box, as_view(samples.coverage()), stroke.color, stroke.alpha);
}

void Canvas::polygon(std::span<const Point> corners, Color color, double alpha) {
  if (corners.size() < 3 ||
      !std::all_of(corners.begin(), corners.end(), [](const Point& p) { return p.allFinite(); })) {
    return;
  }
  std::vector<Segment> edges;
  for (const Point& corner : corners) {
    edges.push_back({corner, corner});
  }
  const PixelBox box = visible(bounds_of(edges));
  if (box.empty()) {
    return;
  }
  Samples samples(box);
  std::vector<cv::Point> fixed;
  for (const Point& corner : corners) {
    // Keeps OpenCV's fixed point from overflowing; the picture is far smaller.
    constexpr double kFar = 30'000.0;
    fixed.push_back(samples.fixed(corner.cwiseMax(-kFar).cwiseMin(kFar)));
  }
  cv::fillPoly(samples.mat(), std::vector<std::vector<cv::Point>>{fixed}, 255, cv::LINE_8, kShift);
  blend(box, as_view(samples.coverage()), color, alpha);
}

void Canvas::rectangle(const Rect& rect, Color color, double alpha) {
  const PixelBox box = visible(rect);
  const auto share = [](double low, double high, int pixel) {
    return std::max(0.0, std::min(high, pixel + 1.0) - std::max(low, static_cast<double>(pixel)));
  };
  for (int y = box.y0; y < box.y1; ++y) {
    const double rows = share(rect.y, rect.bottom(), y) * alpha;
    for (int x = box.x0; x < box.x1; ++x) {
      blend_pixel(x, y, color, rows * share(rect.x, rect.right(), x));
    }
  }
}

void Canvas::outline(const Rect& rect, const Stroke& stroke) {
  const std::vector<Point> corners{{rect.x, rect.y},
                                   {rect.right(), rect.y},
                                   {rect.right(), rect.bottom()},
                                   {rect.x, rect.bottom()},
                                   {rect.x, rect.y}};
  polyline(corners, stroke);
}

void Canvas::disk(const Point& center, double radius_px, Color color, double alpha) {
  if (!center.allFinite()) {
    return;
  }
  const double reach = radius_px + 0.5;
  const PixelBox box = visible({center.x() - reach, center.y() - reach, 2 * reach, 2 * reach});
  // A disk smaller than a pixel is a pale pixel.
  const double strength = alpha * std::min(1.0, 4.0 * radius_px * radius_px);
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const double distance = std::hypot(x + 0.5 - center.x(), y + 0.5 - center.y());
      const double share = std::clamp(reach - distance, 0.0, 1.0);
      if (share > 0.0) {
        blend_pixel(x, y, color, strength * share);
      }
    }
  }
}

void Canvas::image(GrayView image, const Rect& rect, double fade) {
  const PixelBox box = visible(rect);
  if (box.empty() || image.empty()) {
    return;
  }
  const int width = std::max(1, static_cast<int>(std::lround(rect.width)));
  const int height = std::max(1, static_cast<int>(std::lround(rect.height)));
  cv::Mat1b scaled = as_mat(image);
  if (width != image.width || height != image.height) {
    const bool shrinks = width < image.width;
    cv::resize(as_mat(image), scaled, {width, height}, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_CUBIC);
  }
  const int x0 = static_cast<int>(std::lround(rect.x));
  const int y0 = static_cast<int>(std::lround(rect.y));
  for (int y = std::max(box.y0, y0); y < std::min(box.y1, y0 + height); ++y) {
    const std::uint8_t* row = scaled[y - y0];
    for (int x = std::max(box.x0, x0); x < std::min(box.x1, x0 + width); ++x) {
      const std::uint8_t gray = row[x - x0];
      pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] =
          mix({gray, gray, gray}, kPaper, fade);
    }
  }
}

void Canvas::mask(GrayView mask, const Rect& rect, Color color, double alpha) {
  const PixelBox box = visible(rect);
  if (!box.empty() && !mask.empty()) {
    blend(box, as_view(to_coverage(mask, rect, box)), color, alpha);
  }
}

void Canvas::mask_outline(GrayView mask, const Rect& rect, const Stroke& stroke) {
  if (mask.empty()) {
    return;
  }
  // With a border of zeros, so that areas at the edge of the image are closed.
  cv::Mat1b framed;
  cv::copyMakeBorder(as_mat(mask), framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(framed, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::vector<std::vector<Point>> lines;
  for (const std::vector<cv::Point>& contour : contours) {
    std::vector<Point>& line = lines.emplace_back();
    for (const cv::Point& p : contour) {
      line.emplace_back(rect.x + (p.x - 0.5) * rect.width / mask.width,
                        rect.y + (p.y - 0.5) * rect.height / mask.height);
    }
    line.push_back(line.front());
  }
  polylines(lines, stroke);
}

Status Canvas::write_png(const std::filesystem::path& path, imaging::PngEffort effort) const {
  return imaging::write_png_rgb8(path.c_str(), view(), effort);
}

}  // namespace kinetrace::drawing
