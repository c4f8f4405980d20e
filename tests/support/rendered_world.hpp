// A street of textured planes and boxes, ray-cast into both views of a stereo rig. Geometry is exact and the same
// everywhere, pixels are deterministic, and a small pair takes a few milliseconds.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::test {

/// A small rig, quick to render and to process.
[[nodiscard]] inline StereoGeometry small_rig() {
  return {.fx_px = 360.0,
          .fy_px = 360.0,
          .cx_px = 240.0,
          .cy_px = 70.0,
          .baseline_m = 0.5,
          .width_px = 480,
          .height_px = 160};
}

/// A solid textured box; its frame is at the centre. Label 0 makes it part of the background.
struct RenderedBox {
  Eigen::Vector3d size_m{1.8, 1.5, 4.0};
  Se3 T_world_box;
  std::uint8_t label = 0;
};

/// Both views' pixels, and the box that each pixel shows.
struct RenderedPair {
  StereoGeometry geometry;
  std::vector<std::uint8_t> left;
  std::vector<std::uint8_t> right;
  std::vector<std::uint8_t> left_labels;
  std::vector<std::uint8_t> right_labels;

  [[nodiscard]] GrayView view(const std::vector<std::uint8_t>& pixels) const {
    return {pixels.data(), geometry.width_px, geometry.height_px, geometry.width_px};
  }
  /// The pair as pipeline input, ten frames a second; `name` must outlive the result.
  [[nodiscard]] RectifiedPair at(std::int64_t frame_index, std::string_view name = {}) const {
    return {.frame_index = frame_index,
            .timestamp_ns = frame_index * 100'000'000,
            .name = name,
            .left = view(left),
            .right = view(right),
            .geometry = geometry};
  }
};

/// A pair of uniform gray images without texture.
[[nodiscard]] RenderedPair blank_pair(const StereoGeometry& geometry, std::uint8_t gray);

/// Noise with equal contrast per octave, periodic, with a mip pyramid against aliasing.
class NoiseTexture {
 public:
  static constexpr double kTexelsPerMetre = 25.0;

  NoiseTexture();
  /// Gray value about 0 at `texels`; `footprint` = texels per pixel.
  [[nodiscard]] float sample(const Eigen::Vector2f& texels, float footprint) const;

 private:
  static constexpr int kLevels = 7;
  static constexpr int kSize = 512;
  [[nodiscard]] float bilinear(int level, const Eigen::Vector2f& texels) const;
  std::array<std::vector<float>, kLevels> levels_;
};

/// A flat road 1.5 m below the camera's start between walls 7 m to either side, a wall 60 m ahead, and whatever boxes
/// are given.
class RenderedWorld {
 public:
  explicit RenderedWorld(const StereoGeometry& geometry = small_rig()) : geometry_(geometry) {}

  [[nodiscard]] RenderedPair render(const Se3& T_world_cam, std::span<const RenderedBox> boxes = {}) const;
  [[nodiscard]] const StereoGeometry& geometry() const noexcept { return geometry_; }

 private:
  struct Canvas;
  void draw_street(Canvas& canvas) const;
  void draw_box(const RenderedBox& box, int texture_offset, Canvas& canvas) const;
  void draw_view(const Se3& T_world_view, std::span<const RenderedBox> boxes, std::vector<std::uint8_t>& pixels,
                 std::vector<std::uint8_t>& labels) const;

  StereoGeometry geometry_;
  NoiseTexture texture_;
};

/// Static boxes along the street, so that the scene is not all planes.
[[nodiscard]] std::vector<RenderedBox> street_furniture();

}  // namespace kinetrace::test
