// Selection of image regions for a closer look by the network.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/core/track_frame.hpp"

namespace kinetrace::segmentation {

/// Regions half as wide and high as the image, which a network sees enlarged by two against whole images.
class RegionChooser {
 public:
  RegionChooser() = default;
  explicit RegionChooser(const StereoGeometry& geometry) noexcept;

  /// The region with the track that has waited longest, and as many others beside it as fit, nearest first. Empty if no
  /// track fits.
  [[nodiscard]] PixelBox choose(std::span<const Track> tracks) noexcept;
  void reset() noexcept;

 private:
  /// Range of the region's upper left corner.
  struct Range {
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;  ///< Inclusive.
    int y1 = 0;
    [[nodiscard]] bool empty() const noexcept { return x1 < x0 || y1 < y0; }
  };
  struct Look {
    std::uint32_t track_id = 0;
    std::uint64_t region = 0;  ///< Number of the last region that contained it, from 1.
  };

  [[nodiscard]] Range around(const PixelBox& box) const noexcept;
  [[nodiscard]] static Range common_part(const Range& a, const Range& b) noexcept;
  [[nodiscard]] std::uint64_t last_region(const Track& track) const noexcept;
  [[nodiscard]] const Track* waiting_longest(std::span<const Track> tracks) const noexcept;

  int image_width_px_ = 0;
  int image_height_px_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  std::array<Look, kMaxObjects> looks_{};  ///< By slot.
  std::uint64_t regions_ = 0;
};

}  // namespace kinetrace::segmentation
