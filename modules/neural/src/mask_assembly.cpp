#include "mask_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::neural {
namespace {

/// Accuracy of networks at the edges of boxes.
constexpr int kAtBorder_px = 3;

PixelBox box_in_picture(const Box& box, const PlacedPicture& picture) noexcept {
  const auto pixel = [](double position, int first, int end) {
    return static_cast<int>(
        std::clamp(std::round(first + position), static_cast<double>(first), static_cast<double>(end)));
  };
  const Placement& placement = picture.placement;
  const PixelBox& part = picture.part_px;
  return {pixel(placement.picture_x(box.x0), part.x0, part.x1), pixel(placement.picture_y(box.y0), part.y0, part.y1),
          pixel(placement.picture_x(box.x1), part.x0, part.x1), pixel(placement.picture_y(box.y1), part.y0, part.y1)};
}

/// True at a border of the part that is not one of the picture.
bool is_cut(const PixelBox& box, const PlacedPicture& picture) noexcept {
  const PixelBox& part = picture.part_px;
  return (part.x0 > 0 && box.x0 < part.x0 + kAtBorder_px) || (part.y0 > 0 && box.y0 < part.y0 + kAtBorder_px) ||
         (part.x1 < picture.width_px && box.x1 > part.x1 - kAtBorder_px) ||
         (part.y1 < picture.height_px && box.y1 > part.y1 - kAtBorder_px);
}

}  // namespace

MaskAssembly::MaskAssembly(std::size_t max_masks, std::size_t max_runs, const GridSize& largest_grid, Arena& arena)
    : masks_(arena, max_masks),
      runs_(arena, max_runs),
      values_(arena.take<float>(static_cast<std::size_t>(largest_grid.width) *
                                static_cast<std::size_t>(largest_grid.height))),
      row_(arena.take<float>(static_cast<std::size_t>(largest_grid.width))) {}

void MaskAssembly::clear() noexcept {
  masks_.clear();
  runs_.clear();
}

MaskAssembly::Window MaskAssembly::window_of_prototypes(const Box& box, const HeadLayout& layout) noexcept {
  Window window;
  const double cell_px = layout.prototype_stride_px;
  window.cell_width_px = window.cell_height_px = cell_px;
  // A margin of one cell, for interpolation at the border of the box.
  const auto first = [cell_px](float input, int size) {
    return std::clamp(static_cast<int>(std::floor(input / cell_px)) - 1, 0, size - 1);
  };
  const auto last = [cell_px](float input, int size) {
    return std::clamp(static_cast<int>(std::ceil(input / cell_px)) + 1, 1, size);
  };
  window.x0 = first(box.x0, layout.mask_width);
  window.y0 = first(box.y0, layout.mask_height);
  window.width = std::max(1, last(box.x1, layout.mask_width) - window.x0);
  window.height = std::max(1, last(box.y1, layout.mask_height) - window.y0);
  return window;
}

MaskAssembly::Window MaskAssembly::window_of_detection(const Box& box, const HeadLayout& layout) noexcept {
  return {.width = layout.mask_width,
          .height = layout.mask_height,
          .origin_x = box.x0,
          .origin_y = box.y0,
          .cell_width_px = static_cast<double>(box.x1 - box.x0) / layout.mask_width,
          .cell_height_px = static_cast<double>(box.y1 - box.y0) / layout.mask_height};
}

void MaskAssembly::weigh_prototypes(const Candidate& candidate, const Tensor& prototypes,
                                    const Window& window) noexcept {
  const auto count = static_cast<std::size_t>(prototypes.sizes[1]);
  const auto stride = static_cast<std::size_t>(prototypes.sizes[3]);
  const std::size_t plane = static_cast<std::size_t>(prototypes.sizes[2]) * stride;
  const auto width = static_cast<std::size_t>(window.width);
  const std::size_t begin = static_cast<std::size_t>(window.y0) * stride + static_cast<std::size_t>(window.x0);
  std::fill_n(values_.begin(), width * static_cast<std::size_t>(window.height), 0.F);
  for (std::size_t i = 0; i < count; ++i) {
    const float weight = candidate.mask[i];
    for (std::size_t y = 0; y < static_cast<std::size_t>(window.height); ++y) {
      const float* source = prototypes.values.data() + i * plane + begin + y * stride;
      float* target = values_.data() + y * width;
      for (std::size_t x = 0; x < width; ++x) {
        target[x] += weight * source[x];
      }
    }
  }
}

void MaskAssembly::take_probabilities(const Candidate& candidate, const Window& window) noexcept {
  const std::size_t count = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  std::transform(candidate.mask.first, candidate.mask.first + count, values_.begin(),
                 [](float probability) { return probability - 0.5F; });
}

void MaskAssembly::blend_rows(double input_y, const Window& window) noexcept {
  const double y = (input_y - window.origin_y) / window.cell_height_px - 0.5 - window.y0;
  const double clamped = std::clamp(y, 0.0, static_cast<double>(window.height - 1));
  const int above = std::min(static_cast<int>(clamped), std::max(0, window.height - 2));
  const auto part = static_cast<float>(clamped - above);
  const float* upper = values_.data() + static_cast<std::ptrdiff_t>(above) * window.width;
  const float* lower = window.height > 1 ? upper + window.width : upper;
  std::transform(upper, upper + window.width, lower, row_.begin(),
                 [part](float a, float b) { return a + part * (b - a); });
}

float MaskAssembly::value_at(double input_x, const Window& window) const noexcept {
  const double x = (input_x - window.origin_x) / window.cell_width_px - 0.5 - window.x0;
  const double clamped = std::clamp(x, 0.0, static_cast<double>(window.width - 1));
  const auto left = static_cast<std::size_t>(std::min(static_cast<int>(clamped), std::max(0, window.width - 2)));
  const std::size_t right = std::min(left + 1, static_cast<std::size_t>(window.width - 1));
  return row_[left] + static_cast<float>(clamped - static_cast<double>(left)) * (row_[right] - row_[left]);
}

bool MaskAssembly::add_run(std::size_t length) noexcept {
  constexpr std::size_t kMax = std::numeric_limits<std::uint16_t>::max();
  for (; length > kMax; length -= kMax) {
    // A longer run continues after an empty one of the other kind.
    if (!runs_.push_back(static_cast<std::uint16_t>(kMax)) || !runs_.push_back(0)) {
      return false;
    }
  }
  return runs_.push_back(static_cast<std::uint16_t>(length));
}

std::optional<std::size_t> MaskAssembly::trace(const PixelBox& box_px, const PlacedPicture& picture,
                                               const Window& window) noexcept {
  std::size_t pixels = 0;
  std::size_t run = 0;
  bool inside = false;
  for (int y = box_px.y0; y < box_px.y1; ++y) {
    blend_rows(picture.placement.input_y(y - picture.part_px.y0 + 0.5), window);
    for (int x = box_px.x0; x < box_px.x1; ++x) {
      const bool is_mask = value_at(picture.placement.input_x(x - picture.part_px.x0 + 0.5), window) > 0.F;
      if (is_mask != inside) {
        if (!add_run(run)) {
          return std::nullopt;
        }
        run = 0;
        inside = is_mask;
      }
      ++run;
      pixels += is_mask ? 1 : 0;
    }
  }
  return add_run(run) ? std::optional(pixels) : std::nullopt;
}

bool MaskAssembly::add(const Candidate& candidate, std::uint16_t class_id, const HeadLayout& layout, const Tensor& grid,
                       const PlacedPicture& picture) noexcept {
  const PixelBox box_px = box_in_picture(candidate.box, picture);
  if (box_px.empty() || is_cut(box_px, picture)) {
    return true;
  }
  Window window;
  if (layout.kind == HeadLayout::Kind::kDetections) {
    window = window_of_detection(candidate.box, layout);
    take_probabilities(candidate, window);
  } else {
    window = window_of_prototypes(candidate.box, layout);
    weigh_prototypes(candidate, grid, window);
  }
  const std::size_t first = runs_.size();
  const std::optional<std::size_t> pixels = trace(box_px, picture, window);
  const bool has_room = pixels && !masks_.full();
  if (!has_room || *pixels == 0) {
    runs_.resize(first);
    return has_room;
  }
  return masks_.push_back({class_id, candidate.score, box_px, runs_.span().subspan(first)});
}

}  // namespace kinetrace::neural
