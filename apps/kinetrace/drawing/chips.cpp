#include "chips.hpp"

#include <algorithm>
#include <optional>

#include "label_placer.hpp"

namespace kinetrace::drawing {
namespace {

constexpr double kGap_px = 2.0;

struct PlacedText {
  Rect rect;
  std::string text;
};

std::optional<PlacedText> place(LabelPlacer& placer, const Chip& chip, bool is_crowd, const TextStyle& style) {
  const double height = 1.85 * style.size_px;
  double width = 0.0;
  for (std::size_t i = is_crowd && chip.texts.size() > 1 ? 1 : 0; i < chip.texts.size(); ++i) {
    width = text_width(chip.texts[i], style) + style.size_px;
    const double x = chip.target.center().x() - width / 2;
    for (const double y : {chip.target.y - height - kGap_px, chip.target.bottom() + kGap_px}) {
      if (const auto rect = placer.place_at({x, y, width, height})) {
        return PlacedText{*rect, chip.texts[i]};
      }
    }
  }
  if (const auto rect = placer.place(chip.target.center(), width, height, chip.target.height / 2 + kGap_px)) {
    return PlacedText{*rect, chip.texts.back()};
  }
  return std::nullopt;
}

}  // namespace

void draw_chips(Canvas& canvas, const Rect& area, std::vector<Chip> chips, double size_px) {
  std::stable_sort(chips.begin(), chips.end(),
                   [](const Chip& a, const Chip& b) { return a.target.height > b.target.height; });
  LabelPlacer placer(area.grown(-kGap_px));
  for (const Chip& chip : chips) {
    const TextStyle style{.size_px = size_px,
                          .color = readable_on(chip.color),
                          .horizontal = HorizontalAnchor::kCenter,
                          .vertical = VerticalAnchor::kMiddle};
    if (const auto placed = place(placer, chip, chips.size() > kCrowd, style)) {
      canvas.rectangle(placed->rect, chip.color, 0.9);
      canvas.text(placed->rect.center(), placed->text, style);
    }
  }
}

}  // namespace kinetrace::drawing
