// Coarse and fast matching of left patches in the right image, to assess pairs.
#pragma once

#include <array>
#include <cstddef>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::hal {

/// Displacement of a patch in the right image, in pixels of full-size images.
struct PatchMatch {
  double row_px = 0.0;        ///< Right row minus left row.
  double disparity_px = 0.0;  ///< Left column minus right column.
};

/// At most one match for each cell of a grid over the left image.
struct PatchMatches {
  static constexpr int kColumnsOfCells = 8;
  static constexpr int kRowsOfCells = 8;

  std::array<PatchMatch, static_cast<std::size_t>(kColumnsOfCells) * kRowsOfCells> found;
  std::size_t count = 0;
  std::size_t searched = 0;  ///< Cells with texture.
};

/// Range of the disparity search, in pixels of full-size images, both ends included; within +-kMaxDisparity_px.
struct DisparityRange {
  int first_px = 0;
  int last_px = 0;
};
inline constexpr int kMaxDisparity_px = 512;
/// Range of the row search, up and down, in pixels of full-size images.
inline constexpr int kMaxRowShift_px = 12;

/// Halves `source` and removes the local brightness of its rows, so that views of different gain compare.
void prepare_patches(GrayView source, MutableGrayView target) noexcept;

/// Patches of 16x8 pixels of prepared images, by sums of absolute differences; the cost of a match is a fifth below all
/// others of the search range.
[[nodiscard]] PatchMatches match_patches(GrayView left, GrayView right, const DisparityRange& range) noexcept;

}  // namespace kinetrace::hal
