#include "rendered_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::test {
namespace {

constexpr double kRoad_m = 1.5;
constexpr double kWall_m = 7.0;
constexpr double kEnd_m = 60.0;
constexpr float kMeanGray = 128.F;
constexpr float kOctaveGray = 44.F;

// A number in [-1, 1) for each grid point of an octave.
float lattice(int x, int y, int octave) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
           static_cast<std::uint32_t>(octave) * 0xC2B2AE3DU;
  h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12U)) * 0x297A2D39U;
  return static_cast<float>(h ^ (h >> 15U)) / 2147483648.F - 1.F;
}

float ease(float t) {
  return t * t * (3.F - 2.F * t);
}

float mix(float a, float b, float t) {
  return a + t * (b - a);
}

// Smooth noise with `cell` texels between grid points, of period `size`.
float octave_value(int x, int y, int cell, int size) {
  const int cells = size / cell;
  const int x0 = x / cell;
  const int y0 = y / cell;
  const int x1 = (x0 + 1) % cells;
  const int y1 = (y0 + 1) % cells;
  const float ax = ease(static_cast<float>(x % cell) / static_cast<float>(cell));
  const float ay = ease(static_cast<float>(y % cell) / static_cast<float>(cell));
  return mix(mix(lattice(x0, y0, cell), lattice(x1, y0, cell), ax),
             mix(lattice(x0, y1, cell), lattice(x1, y1, cell), ax), ay);
}

std::uint8_t to_gray(float value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(kMeanGray + value), 0L, 255L));
}

}  // namespace

NoiseTexture::NoiseTexture() {
  levels_[0].resize(static_cast<std::size_t>(kSize) * kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      float sum = 0.F;
      for (int cell = 4; cell <= 64; cell *= 2) {
        sum += octave_value(x, y, cell, kSize);
      }
      levels_[0][static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x)] = kOctaveGray * sum;
    }
  }
  for (std::size_t level = 1; level < kLevels; ++level) {
    const std::size_t size = static_cast<std::size_t>(kSize) >> level;
    const std::vector<float>& finer = levels_[level - 1];
    levels_[level].resize(size * size);
    for (std::size_t y = 0; y < size; ++y) {
      for (std::size_t x = 0; x < size; ++x) {
        const std::size_t first = 2 * y * 2 * size + 2 * x;
        levels_[level][y * size + x] =
            0.25F * (finer[first] + finer[first + 1] + finer[first + 2 * size] + finer[first + 2 * size + 1]);
      }
    }
  }
}

float NoiseTexture::bilinear(int level, const Eigen::Vector2f& texels) const {
  const int size = kSize >> level;
  const float scale = 1.F / static_cast<float>(1 << level);
  // Centres of coarser texels lie between those of finer ones.
  const float x = (texels.x() + 0.5F) * scale - 0.5F;
  const float y = (texels.y() + 0.5F) * scale - 0.5F;
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const auto wrap = [mask = size - 1](int i) { return static_cast<std::size_t>(i & mask); };
  const std::size_t x0 = wrap(static_cast<int>(floor_x));
  const std::size_t x1 = wrap(static_cast<int>(floor_x) + 1);
  const std::size_t row0 = wrap(static_cast<int>(floor_y)) * static_cast<std::size_t>(size);
  const std::size_t row1 = wrap(static_cast<int>(floor_y) + 1) * static_cast<std::size_t>(size);
  const std::vector<float>& t = levels_[static_cast<std::size_t>(level)];
  const float ax = x - floor_x;
  return mix(mix(t[row0 + x0], t[row0 + x1], ax), mix(t[row1 + x0], t[row1 + x1], ax), y - floor_y);
}

float NoiseTexture::sample(const Eigen::Vector2f& texels, float footprint) const {
  const float level = std::clamp(std::log2(std::max(1.F, footprint)), 0.F, static_cast<float>(kLevels) - 1.001F);
  const int finer = static_cast<int>(level);
  return mix(bilinear(finer, texels), bilinear(finer + 1, texels), level - static_cast<float>(finer));
}

/// One view's image while it is drawn.
struct RenderedWorld::Canvas {
  Se3 T_world_view;
  std::span<std::uint8_t> pixels;
  std::span<std::uint8_t> labels;
  std::vector<float> depth_m;
};

RenderedPair blank_pair(const StereoGeometry& geometry, std::uint8_t gray) {
  const auto count = static_cast<std::size_t>(geometry.width_px) * static_cast<std::size_t>(geometry.height_px);
  const std::vector<std::uint8_t> pixels(count, gray);
  const std::vector<std::uint8_t> labels(count, kBackgroundLabel);
  return {geometry, pixels, pixels, labels, labels};
}

RenderedPair RenderedWorld::render(const Se3& T_world_cam, std::span<const RenderedBox> boxes) const {
  RenderedPair pair = blank_pair(geometry_, 0);
  Se3 T_left_right;
  T_left_right.translation.x() = geometry_.baseline_m;
  draw_view(T_world_cam, boxes, pair.left, pair.left_labels);
  draw_view(T_world_cam * T_left_right, boxes, pair.right, pair.right_labels);
  return pair;
}

void RenderedWorld::draw_view(const Se3& T_world_view, std::span<const RenderedBox> boxes,
                              std::vector<std::uint8_t>& pixels, std::vector<std::uint8_t>& labels) const {
  Canvas canvas{T_world_view, pixels, labels, std::vector<float>(pixels.size(), std::numeric_limits<float>::max())};
  draw_street(canvas);
  int offset = 0;
  for (const RenderedBox& box : boxes) {
    draw_box(box, ++offset, canvas);
  }
}

void RenderedWorld::draw_street(Canvas& canvas) const {
  const Eigen::Vector3d& origin = canvas.T_world_view.translation;
  std::size_t i = 0;
  for (int v = 0; v < geometry_.height_px; ++v) {
    for (int u = 0; u < geometry_.width_px; ++u, ++i) {
      const Eigen::Vector3d ray =
          canvas.T_world_view.rotation *
          Eigen::Vector3d((u - geometry_.cx_px) / geometry_.fx_px, (v - geometry_.cy_px) / geometry_.fy_px, 1.0);
      // The nearest of the road, the wall on the ray's side and the wall ahead; `axis` is the plane's normal.
      double depth = (kEnd_m - origin.z()) / ray.z();
      int axis = 2;
      const double to_wall = ((ray.x() < 0.0 ? -kWall_m : kWall_m) - origin.x()) / ray.x();
      if (to_wall > 0.0 && to_wall < depth) {
        depth = to_wall;
        axis = 0;
      }
      const double to_road = (kRoad_m - origin.y()) / ray.y();
      if (to_road > 0.0 && to_road < depth) {
        depth = to_road;
        axis = 1;
      }
      const Eigen::Vector3d p = origin + depth * ray;
      const Eigen::Vector2d metres = axis == 0   ? Eigen::Vector2d(p.z(), p.y() + p.x())
                                     : axis == 1 ? Eigen::Vector2d(p.x() + 3.0, p.z() + 4.0)
                                                 : Eigen::Vector2d(p.x() + 5.0, p.y() + 2.0);
      const double cosine = std::abs(ray[axis]) / ray.norm();
      const double footprint = depth / geometry_.fx_px * NoiseTexture::kTexelsPerMetre / cosine;
      canvas.pixels[i] = to_gray(
          texture_.sample((metres * NoiseTexture::kTexelsPerMetre).cast<float>(), static_cast<float>(footprint)));
      canvas.depth_m[i] = static_cast<float>(depth);
    }
  }
}

void RenderedWorld::draw_box(const RenderedBox& box, int texture_offset, Canvas& canvas) const {
  const Se3 T_box_view = box.T_world_box.inverse() * canvas.T_world_view;
  const Eigen::Vector3d half = 0.5 * box.size_m;
  // Corners in the image; a box beside the view may be anywhere.
  PixelBox region;
  bool beside = false;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                               (corner & 4) != 0 ? 1.0 : -1.0);
    const Eigen::Vector3d p = T_box_view.inverse() * half.cwiseProduct(sign);
    beside = beside || p.z() < 0.1;
    const Eigen::Vector3d uvr = geometry_.project(p);
    if (!beside) {
      region.include(static_cast<int>(std::lround(uvr.x())), static_cast<int>(std::lround(uvr.y())));
    }
  }
  region = beside ? PixelBox{0, 0, geometry_.width_px, geometry_.height_px}
                  : PixelBox{std::max(0, region.x0), std::max(0, region.y0), std::min(geometry_.width_px, region.x1),
                             std::min(geometry_.height_px, region.y1)};
  const Eigen::Vector3d& origin = T_box_view.translation;
  for (int v = region.y0; v < region.y1; ++v) {
    for (int u = region.x0; u < region.x1; ++u) {
      const Eigen::Vector3d ray = T_box_view.rotation * Eigen::Vector3d((u - geometry_.cx_px) / geometry_.fx_px,
                                                                        (v - geometry_.cy_px) / geometry_.fy_px, 1.0);
      // Slab test: where the ray has entered all three slabs and left none.
      double enter = 0.0;
      double leave = std::numeric_limits<double>::max();
      Eigen::Index face = 0;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double a = (-half[axis] - origin[axis]) / ray[axis];
        const double b = (half[axis] - origin[axis]) / ray[axis];
        leave = std::min(leave, std::max(a, b));
        if (std::min(a, b) > enter) {
          enter = std::min(a, b);
          face = axis;
        }
      }
      const std::size_t i =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(geometry_.width_px) + static_cast<std::size_t>(u);
      if (enter <= 0.0 || enter >= leave || enter >= static_cast<double>(canvas.depth_m[i])) {
        continue;
      }
      const Eigen::Vector3d p = origin + enter * ray;
      const Eigen::Vector2d metres(p[(face + 1) % 3] + 2.9 * texture_offset, p[(face + 2) % 3] + 1.3 * texture_offset);
      const double cosine = std::abs(ray[face]) / ray.norm();
      const double footprint = enter / geometry_.fx_px * NoiseTexture::kTexelsPerMetre / cosine;
      canvas.pixels[i] = to_gray(
          texture_.sample((metres * NoiseTexture::kTexelsPerMetre).cast<float>(), static_cast<float>(footprint)));
      canvas.labels[i] = box.label;
      canvas.depth_m[i] = static_cast<float>(enter);
    }
  }
}

std::vector<RenderedBox> street_furniture() {
  std::vector<RenderedBox> boxes;
  for (int i = 0; i < 6; ++i) {
    const double side = i % 2 == 0 ? -1.0 : 1.0;
    RenderedBox box;
    box.size_m = {1.2, 3.0 + 0.5 * i, 1.5};
    box.T_world_box.translation = {side * (5.0 + 0.3 * i), kRoad_m - 0.5 * box.size_m.y(), 9.0 + 6.0 * i};
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace kinetrace::test
