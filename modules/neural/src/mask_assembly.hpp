// Masks in picture pixels from a network's coarse grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "candidates.hpp"
#include "heads.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "letterbox.hpp"

namespace kinetrace::neural {

/// A part of a picture, and its placement in the network's input.
struct PlacedPicture {
  int width_px = 0;  ///< Of the picture.
  int height_px = 0;
  PixelBox part_px;     ///< Part of it used as input.
  Placement placement;  ///< Of the part.
};

struct GridSize {
  int width = 0;
  int height = 0;
};

/// Prototype masks weighted by an instance's coefficients (Bolya et al. 2019, YOLACT, eq. 1), or the grid of a Mask
/// R-CNN (He et al. 2017, sec. 3), interpolated bilinearly and thresholded at probability one half, within the box.
class MaskAssembly {
 public:
  MaskAssembly() = default;
  MaskAssembly(std::size_t max_masks, std::size_t max_runs, const GridSize& largest_grid, Arena& arena);

  void clear() noexcept;
  /// False, with nothing added, at capacity. Masks without pixels, and masks cut by the border of the part, are
  /// skipped. `grid`: the output with prototypes or masks.
  [[nodiscard]] bool add(const Candidate& candidate, std::uint16_t class_id, const HeadLayout& layout,
                         const Tensor& grid, const PlacedPicture& picture) noexcept;
  [[nodiscard]] std::span<const RunLengthMask> masks() const noexcept { return masks_.span(); }

 private:
  /// The cells of the grid around a box; cell c of the grid covers input pixels origin + [c, c + 1) * cell_px.
  struct Window {
    int x0 = 0;
    int y0 = 0;
    int width = 0;
    int height = 0;
    double origin_x = 0.0;
    double origin_y = 0.0;
    double cell_width_px = 1.0;
    double cell_height_px = 1.0;
  };
  [[nodiscard]] static Window window_of_prototypes(const Box& box, const HeadLayout& layout) noexcept;
  [[nodiscard]] static Window window_of_detection(const Box& box, const HeadLayout& layout) noexcept;
  void weigh_prototypes(const Candidate& candidate, const Tensor& prototypes, const Window& window) noexcept;
  void take_probabilities(const Candidate& candidate, const Window& window) noexcept;
  /// Interpolates the grid row at this height of the input.
  void blend_rows(double input_y, const Window& window) noexcept;
  [[nodiscard]] float value_at(double input_x, const Window& window) const noexcept;
  /// Adds the runs of the pixels of `box_px`; returns the number of pixels inside, or none at capacity.
  [[nodiscard]] std::optional<std::size_t> trace(const PixelBox& box_px, const PlacedPicture& picture,
                                                 const Window& window) noexcept;
  [[nodiscard]] bool add_run(std::size_t length) noexcept;

  FixedVector<RunLengthMask> masks_;
  FixedVector<std::uint16_t> runs_;
  std::span<float> values_;  ///< Of the window: above 0 inside.
  std::span<float> row_;
};

}  // namespace kinetrace::neural
