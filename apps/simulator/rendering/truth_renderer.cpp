#include "rendering/truth_renderer.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "rendering/tile.hpp"
#include "util/parallel.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

// Bit-identical to SampleRays.
Eigen::Vector2f pixel_ray(const StereoGeometry& g, int x, int y) {
  return Eigen::Vector2d((x - g.cx_px) / g.fx_px, (y - g.cy_px) / g.fy_px).cast<float>();
}

class CentreTracer {
 public:
  CentreTracer(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_view)
      : world_(world),
        geometry_(geometry),
        origin_(T_scene_view.translation.cast<float>()),
        R_scene_view_(T_scene_view.rotation.cast<float>()) {}

  // The tile whose upper left pixel is (x0, y0).
  void trace(int x0, int y0, TruthImages& truth) const {
    std::array<std::array<int, 2>, kTilePixels> pixels{};
    std::size_t count = 0;
    for (const auto& [x, y] : kTileOrder) {
      if (truth.depth_m.contains(x0 + x, y0 + y)) {
        pixels[count++] = {x0 + x, y0 + y};
      }
    }
    for (std::size_t first = 0; first < count; first += RayPacket::kSize) {
      trace(std::span(pixels).subspan(first, std::min(RayPacket::kSize, count - first)), truth);
    }
  }

  [[nodiscard]] bool meets(std::size_t part, int x, int y) const {
    return world_.meets_part(part, origin_, R_scene_view_ * pixel_ray(geometry_, x, y).homogeneous());
  }

 private:
  void trace(std::span<const std::array<int, 2>> pixels, TruthImages& truth) const {
    RayPacket packet;
    packet.count = pixels.size();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto& [x, y] = pixels[i];
      packet.set_origin(i, origin_);
      packet.set_direction(i, R_scene_view_ * pixel_ray(geometry_, x, y).homogeneous());
    }
    world_.trace(packet);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto& [x, y] = pixels[i];
      if (packet.part[i] != RayPacket::kMiss) {
        // Rays have unit length along the optical axis, so that distances are depths.
        truth.depth_m.at(x, y) = packet.distance[i];
        truth.actors.at(x, y) = world_.actor_label(packet.part[i]);
      }
    }
  }

  const RayWorld& world_;
  StereoGeometry geometry_;
  Vector3f origin_;
  Eigen::Matrix3f R_scene_view_;
};

std::vector<std::size_t> parts_of(const RayWorld& world, int actor) {
  std::vector<std::size_t> parts;
  for (std::size_t part = 1; part < world.parts().size(); ++part) {
    if (world.parts()[part].actor == actor) {
      parts.push_back(part);
    }
  }
  return parts;
}

}  // namespace

TruthImages render_truth(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_view, int threads) {
  TruthImages truth(geometry.width_px, geometry.height_px);
  const CentreTracer tracer(world, geometry, T_scene_view);
  for_each_index((geometry.height_px + kTileSide_px - 1) / kTileSide_px, threads, [&](int row) {
    for (int x = 0; x < geometry.width_px; x += kTileSide_px) {
      tracer.trace(x, kTileSide_px * row, truth);
    }
  });
  return truth;
}

int unoccluded_pixels(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_view, int actor,
                      const PixelBox& search_px) {
  const CentreTracer tracer(world, geometry, T_scene_view);
  const std::vector<std::size_t> parts = parts_of(world, actor);
  // A large object is counted on a coarser grid: one pixel in four.
  const int step = search_px.width() * search_px.height() > 4000 ? 2 : 1;
  int count = 0;
  for (int y = search_px.y0; y < search_px.y1; y += step) {
    for (int x = search_px.x0; x < search_px.x1; x += step) {
      if (std::any_of(parts.begin(), parts.end(), [&](std::size_t part) { return tracer.meets(part, x, y); })) {
        count += step * step;
      }
    }
  }
  return count;
}

}  // namespace kinetrace::simulator
