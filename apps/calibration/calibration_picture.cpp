#include <array>
#include <cmath>
#include <cstdio>

#include "calibration_report.hpp"
#include "drawing/canvas.hpp"
#include "drawing/color.hpp"

namespace kinetrace::calibration {
namespace {

using drawing::Canvas;
using drawing::Point;
using drawing::Rect;

constexpr double kPanelWidth_px = 720.0;
constexpr double kMargin_px = 28.0;
constexpr double kCaption_px = 34.0;

/// An image's area on the page.
struct Panel {
  Rect rect;
  int width_px = 0;

  [[nodiscard]] double scale() const { return rect.width / width_px; }
  [[nodiscard]] Point at(const Eigen::Vector2d& px) const {
    return {rect.x + (px.x() + 0.5) * scale(), rect.y + (px.y() + 0.5) * scale()};
  }
};

void caption(Canvas& canvas, const Panel& panel, const std::string& text) {
  canvas.text({panel.rect.x, panel.rect.y - 10.0}, text, {.size_px = 11.0});
  canvas.rectangle(panel.rect, drawing::kPanel);
}

void draw_coverage(Canvas& canvas, const Panel& panel, const ViewCollector& views, bool is_left) {
  for (std::size_t i = 0; i < views.views().size(); ++i) {
    const BoardView& view = views.views()[i];
    const drawing::Color color = drawing::line_style(static_cast<int>(i)).color;
    for (const Corner& corner : is_left ? view.left : view.right) {
      canvas.disk(panel.at(corner.px), 2.0, color, 0.7);
    }
  }
}

// The mean residual around a point shows deviations from the lens model; single residuals are noise.
void draw_residuals(Canvas& canvas, const Panel& panel, const StereoEstimate& estimate, bool is_left, int height_px,
                    double magnification) {
  constexpr int kColumns = 16;
  constexpr int kRows = 12;
  struct Cell {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
  };
  std::array<Cell, static_cast<std::size_t>(kColumns) * kRows> cells{};
  for (const Residual& residual : estimate.residuals) {
    if (residual.is_left != is_left) {
      continue;
    }
    const Point p = panel.at(residual.px);
    canvas.line(p, p + magnification * panel.scale() * residual.error_px,
                {.color = drawing::kFrame, .width_px = 1.0, .alpha = 0.5});
    const int column = std::clamp(static_cast<int>(residual.px.x() * kColumns / panel.width_px), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(residual.px.y() * kRows / height_px), 0, kRows - 1);
    Cell& cell = cells[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
    cell.sum += residual.error_px;
    ++cell.count;
  }
  for (int i = 0; i < static_cast<int>(cells.size()); ++i) {
    const Cell& cell = cells[static_cast<std::size_t>(i)];
    constexpr int kMinCorners = 5;
    if (cell.count < kMinCorners) {
      continue;
    }
    const int column = i % kColumns;
    const int row = i / kColumns;
    const Eigen::Vector2d middle((column + 0.5) * panel.width_px / kColumns, (row + 0.5) * height_px / kRows);
    const Point p = panel.at(middle);
    const Point end = p + magnification * panel.scale() * cell.sum / cell.count;
    canvas.line(p, end, {.color = drawing::kRed, .width_px = 2.0});
    canvas.disk(p, 2.5, drawing::kRed);
  }
}

std::string percent_text(const char* image, double part) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%s image: corners seen in %.0f %% of its cells", image, 100.0 * part);
  return text.data();
}

std::string residual_text(const char* image, double rms_px, double magnification) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(),
                "%s image: residuals, %.3f px RMS, drawn %.0f times as long; red: mean around", image, rms_px,
                magnification);
  return text.data();
}

}  // namespace

Status write_picture(const TargetCalibration& calibration, const ViewCollector& views,
                     const std::filesystem::path& path) {
  const StereoEstimate& estimate = calibration.estimate;
  const int width_px = estimate.rig.left.width_px;
  const int height_px = estimate.rig.left.height_px;
  const double panel_height_px = std::round(kPanelWidth_px * height_px / width_px);
  Canvas canvas(static_cast<int>(2 * kPanelWidth_px + 3 * kMargin_px),
                static_cast<int>(2 * (panel_height_px + kCaption_px) + 2 * kMargin_px), drawing::kPaper);
  const auto panel = [&](int column, int row) {
    return Panel{{kMargin_px + column * (kPanelWidth_px + kMargin_px),
                  kMargin_px + kCaption_px + row * (panel_height_px + kCaption_px), kPanelWidth_px, panel_height_px},
                 width_px};
  };
  const Assessment assessment = views.assess();
  const double magnification = std::clamp(std::round(10.0 / std::max(estimate.sigma_px, 1e-3)), 1.0, 1000.0);
  for (const bool is_left : {true, false}) {
    const char* name = is_left ? "left" : "right";
    const Panel above = panel(is_left ? 0 : 1, 0);
    const Panel below = panel(is_left ? 0 : 1, 1);
    caption(canvas, above, percent_text(name, is_left ? assessment.left_coverage : assessment.right_coverage));
    caption(canvas, below, residual_text(name, is_left ? estimate.left_rms_px : estimate.right_rms_px, magnification));
    canvas.clip(above.rect);
    draw_coverage(canvas, above, views, is_left);
    canvas.clip(below.rect);
    draw_residuals(canvas, below, estimate, is_left, height_px, magnification);
    canvas.unclip();
    canvas.outline(above.rect, {.color = drawing::kFrame, .width_px = 1.0});
    canvas.outline(below.rect, {.color = drawing::kFrame, .width_px = 1.0});
  }
  return canvas.write_png(path);
}

}  // namespace kinetrace::calibration
