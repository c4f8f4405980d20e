#include "truth_renderer.hpp"

#include <algorithm>

#include "parallel.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

Vector3f pixel_ray(const StereoGeometry& g, int x, int y) {
  return Eigen::Vector3d((x - g.cx_px) / g.fx_px, (y - g.cy_px) / g.fy_px, 1.0).cast<float>();
}

class CentreTracer {
 public:
  CentreTracer(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_eye)
      : world_(world),
        geometry_(geometry),
        origin_(T_scene_eye.translation.cast<float>()),
        R_scene_eye_(T_scene_eye.rotation.cast<float>()) {}

  // The square of four by four pixels whose upper left one is (x0, y0).
  void trace(int x0, int y0, TruthImages& truth) const {
    constexpr int kSide = 4;
    RayPacket packet;
    for (int i = 0; i < RayPacket::kSize; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vector3f direction = R_scene_eye_ * pixel_ray(geometry_, x0 + i % kSide, y0 + i / kSide);
      packet.active[k] = -1;
      packet.origin_x[k] = origin_.x();
      packet.origin_y[k] = origin_.y();
      packet.origin_z[k] = origin_.z();
      packet.direction_x[k] = direction.x();
      packet.direction_y[k] = direction.y();
      packet.direction_z[k] = direction.z();
    }
    world_.trace(packet);
    for (int i = 0; i < RayPacket::kSize; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const int x = x0 + i % kSide;
      const int y = y0 + i / kSide;
      if (packet.part[k] != RayPacket::kMiss && truth.depth_m.contains(x, y)) {
        // Rays have length one along the optical axis, so that distances are depths.
        truth.depth_m.at(x, y) = packet.distance[k];
        truth.actors.at(x, y) = static_cast<std::uint16_t>(world_.parts()[packet.part[k]].actor + 1);
      }
    }
  }

  [[nodiscard]] bool meets(std::size_t part, int x, int y) const {
    return world_.meets_part(part, origin_, R_scene_eye_ * pixel_ray(geometry_, x, y));
  }

 private:
  const RayWorld& world_;
  StereoGeometry geometry_;
  Vector3f origin_;
  Eigen::Matrix3f R_scene_eye_;
};

}  // namespace

TruthImages render_truth(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_eye, int threads) {
  TruthImages truth{Image<std::uint16_t>(geometry.width_px, geometry.height_px),
                    Image<float>(geometry.width_px, geometry.height_px)};
  const CentreTracer tracer(world, geometry, T_scene_eye);
  for_each_index((geometry.height_px + 3) / 4, threads, [&](int row) {
    for (int x = 0; x < geometry.width_px; x += 4) {
      tracer.trace(x, 4 * row, truth);
    }
  });
  return truth;
}

int unoccluded_pixels(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_eye, int actor,
                      const PixelBox& search_px) {
  const CentreTracer tracer(world, geometry, T_scene_eye);
  // A large object is counted on a coarser grid: one pixel in four.
  const int step = search_px.width() * search_px.height() > 4000 ? 2 : 1;
  int count = 0;
  for (int y = search_px.y0; y < search_px.y1; y += step) {
    for (int x = search_px.x0; x < search_px.x1; x += step) {
      for (std::size_t part = 1; part < world.parts().size(); ++part) {
        if (world.parts()[part].actor == actor && tracer.meets(part, x, y)) {
          count += step * step;
          break;
        }
      }
    }
  }
  return count;
}

}  // namespace kinetrace::simulator
