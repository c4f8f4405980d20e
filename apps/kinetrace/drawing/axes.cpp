#include "axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace kinetrace::drawing {
namespace {

constexpr double kTickSize_px = 8.5;
constexpr double kLabelSize_px = 9.5;
constexpr double kGap_px = 7.0;
constexpr double kPixelsPerTickX = 72.0;
constexpr double kPixelsPerTickY = 36.0;

double share_of(const Axis& axis, double value) {
  double share = 0.0;
  if (axis.logarithmic) {
    if (!(value > 0.0)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    share = std::log(value / axis.range.low) / std::log(axis.range.high / axis.range.low);
  } else {
    share = (value - axis.range.low) / axis.range.size();
  }
  return axis.reversed ? 1.0 - share : share;
}

std::vector<Tick> ticks_of(const Axis& axis, double length_px, double pixels_per_tick) {
  return axis.logarithmic ? log_ticks(axis.range)
                          : linear_ticks(axis.range, std::max(2, static_cast<int>(length_px / pixels_per_tick)));
}

bool is_within(const Range& range, double value) {
  // Tolerance, so that rounding does not lose a tick at the end of an axis.
  const double slack = 1e-9 * range.size();
  return value >= range.low - slack && value <= range.high + slack;
}

}  // namespace

std::optional<Range> quantile_range(std::vector<double>& values, double share) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) {
    return std::nullopt;
  }
  const auto at = [&](double q) {
    const auto place = static_cast<std::ptrdiff_t>(std::lround(q * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), values.begin() + place, values.end());
    return values[static_cast<std::size_t>(place)];
  };
  const double low = at(share);
  return Range{low, at(1.0 - share)};
}

double round_below(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double factor : {10.0, 5.0, 2.0}) {
    // A round limit may be too small by a rounding error.
    if (factor * power <= limit * (1.0 + 1e-9)) {
      return factor * power;
    }
  }
  return power;
}

double round_above(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= limit * (1.0 - 1e-9)) {
      return factor * power;
    }
  }
  return 10.0 * power;
}

std::string tick_label(double value, double step) {
  std::array<char, 32> text{};
  const double size = std::max(std::abs(value), std::abs(step));
  if (size >= 1e6 || (step < 1e-4 && step > 0.0)) {
    std::snprintf(text.data(), text.size(), "%.3g", value);
  } else {
    const int digits = step >= 1.0 ? 0 : static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
    // Never "-0".
    std::snprintf(text.data(), text.size(), "%.*f", digits, std::abs(value) < step * 1e-6 ? 0.0 : value);
  }
  return text.data();
}

std::vector<Tick> linear_ticks(const Range& range, int most) {
  std::vector<Tick> ticks;
  if (!(range.size() > 0.0) || !std::isfinite(range.size())) {
    return ticks;
  }
  const double step = round_above(range.size() / most);
  for (double k = std::ceil(range.low / step - 1e-9); is_within(range, k * step); ++k) {
    ticks.push_back({k * step, tick_label(k * step, step)});
  }
  return ticks;
}

std::vector<Tick> log_ticks(const Range& range) {
  std::vector<Tick> ticks;
  if (!(range.low > 0.0) || !(range.high > range.low) || !std::isfinite(range.high)) {
    return ticks;
  }
  const double decades = std::log10(range.high / range.low);
  const auto every = static_cast<int>(std::ceil(decades / 8.0));
  for (int power = static_cast<int>(std::floor(std::log10(range.low) + 1e-9));; ++power) {
    const double unit = std::pow(10.0, power);
    if (unit > range.high * (1.0 + 1e-9)) {
      return ticks;
    }
    for (int factor = 1; factor < 10; ++factor) {
      const double value = factor * unit;
      if (value < range.low * (1.0 - 1e-9) || value > range.high * (1.0 + 1e-9)) {
        continue;
      }
      const bool has_number = (factor == 1 && power % every == 0) || (decades < 2.2 && (factor == 2 || factor == 5)) ||
                              (decades < 0.7 && factor != 7 && factor != 9);
      ticks.push_back({value, has_number ? tick_label(value, unit) : std::string()});
    }
  }
}

Axes::Axes(const Rect& area, Axis x, Axis y) : area_(area), x_(std::move(x)), y_(std::move(y)) {}

Point Axes::to_canvas(double x, double y) const {
  return {area_.x + share_of(x_, x) * area_.width, area_.bottom() - share_of(y_, y) * area_.height};
}

void Axes::draw_ticks_x(Canvas& canvas) const {
  double free_from = -std::numeric_limits<double>::infinity();
  std::vector<Tick> ticks = ticks_of(x_, area_.width, kPixelsPerTickX);
  if (x_.reversed) {
    std::reverse(ticks.begin(), ticks.end());
  }
  const TextStyle style{.size_px = kTickSize_px,
                        .color = kMuted,
                        .horizontal = HorizontalAnchor::kCenter,
                        .vertical = VerticalAnchor::kTop};
  for (const Tick& tick : ticks) {
    const double x = area_.x + share_of(x_, tick.value) * area_.width;
    canvas.line({x, area_.y}, {x, area_.bottom()}, {.color = kGrid, .width_px = tick.label.empty() ? 0.6 : 1.0});
    const double half = text_width(tick.label, style) / 2;
    if (!tick.label.empty() && x - half >= free_from) {
      canvas.text({x, area_.bottom() + kGap_px}, tick.label, style);
      free_from = x + half + kGap_px;
    }
  }
}

void Axes::draw_ticks_y(Canvas& canvas) const {
  double free_up_to = std::numeric_limits<double>::infinity();
  std::vector<Tick> ticks = ticks_of(y_, area_.height, kPixelsPerTickY);
  if (y_.reversed) {
    std::reverse(ticks.begin(), ticks.end());
  }
  const TextStyle style{.size_px = kTickSize_px,
                        .color = kMuted,
                        .horizontal = HorizontalAnchor::kRight,
                        .vertical = VerticalAnchor::kMiddle};
  for (const Tick& tick : ticks) {
    const double y = area_.bottom() - share_of(y_, tick.value) * area_.height;
    canvas.line({area_.x, y}, {area_.right(), y}, {.color = kGrid, .width_px = tick.label.empty() ? 0.6 : 1.0});
    if (!tick.label.empty() && y + kTickSize_px <= free_up_to) {
      // Labels at the ends must not protrude beyond the area.
      const double inside = std::clamp(y, area_.y + kTickSize_px / 2, area_.bottom() - kTickSize_px / 2);
      canvas.text({area_.x - kGap_px, inside}, tick.label, style);
      free_up_to = y - kTickSize_px;
    }
  }
}

void Axes::draw(Canvas& canvas) const {
  canvas.rectangle(area_, kPanel);
  draw_ticks_x(canvas);
  draw_ticks_y(canvas);
  canvas.outline(area_, {.color = kFrame, .width_px = 1.0});
  TextStyle style{.size_px = kLabelSize_px, .horizontal = HorizontalAnchor::kCenter};
  canvas.text({area_.center().x(), area_.bottom() + kMarginBelow_px - kLabelSize_px}, x_.label, style);
  style.upwards = true;
  canvas.text({area_.x - kMarginLeft_px + kLabelSize_px + 4.0, area_.center().y()}, y_.label, style);
}

Rect inside_margins(const Rect& rect) {
  return {rect.x + kMarginLeft_px, rect.y, rect.width - kMarginLeft_px, rect.height - kMarginBelow_px};
}

}  // namespace kinetrace::drawing
