// Ray hits in a small square of pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "camera/camera_rig.hpp"
#include "rendering/ray_world.hpp"
#include "rendering/tile_grid.hpp"
#include "shading/surface_pack.hpp"
#include "world/surface.hpp"

namespace kinetrace::simulator {

/// One ray of one pixel and its hit. Two cache lines; probes use only the first.
struct alignas(64) Sample {
  Eigen::Vector3f direction;              ///< Scene frame; not of unit length.
  std::uint32_t part = RayPacket::kMiss;  ///< Index into RayWorld::parts().
  std::uint32_t triangle = RayPacket::kMiss;
  float distance = 0.F;  ///< In units of the direction's length.
  float u = 0.F;         ///< Barycentric coordinates of the triangle's second and third corner.
  float v = 0.F;
  const Paint* paint = nullptr;  ///< Null for the sky, and until the hit has been located.
  float in_sun = 0.F;            ///< 1 where the sun is not blocked.
  Eigen::Vector3f normal;        ///< Interpolated, scene frame.
  Eigen::Vector3f face_normal;   ///< Of the triangle, scene frame, towards the viewer.
  SurfacePoint local;            ///< In the part's frame.
};

/// Most samples of a pixel.
inline constexpr std::size_t kMaxSamples = 16;

/// Whether both lie on the same smooth piece of the same surface.
[[nodiscard]] inline bool alike(const Sample& a, const Sample& b) {
  if (a.paint == nullptr || b.paint == nullptr) {
    return a.paint == b.paint;
  }
  return a.part == b.part && a.paint->material == b.paint->material && a.paint->seed == b.paint->seed &&
         a.paint->tone == b.paint->tone && a.normal.dot(b.normal) > 0.95F;
}

/// Aspect ratio of the pixel's footprint on the sample's surface.
[[nodiscard]] inline float stretch_of(const Sample& sample) {
  const float facing = std::abs(sample.face_normal.dot(sample.direction)) / sample.direction.norm();
  return 1.F / std::max(facing, 0.02F);
}

/// Longer footprints need more than one texture sample.
inline constexpr float kElongated = 1.8F;

/// Traces tile by tile. A pixel is the mean of its samples; they are not traced individually if the rays through its
/// centre and one sample, and those of its neighbours, show that all samples would have the same content. Holds working
/// memory: one for each thread.
class TileSampler {
 public:
  /// All must outlive the sampler.
  TileSampler(const RayWorld& world, const SampleRays& rays, const ViewPose& view);

  /// Traces and shadows the tile whose upper left pixel is (x0, y0).
  void trace(int x0, int y0);

  enum class Content {
    kTriangle,  ///< One flat triangle of the static world, or the sky: samples are extrapolated from the centre.
    kSurface,   ///< One smooth surface seen from the front: the centre represents the samples.
    kMixed,     ///< Any content: all samples are traced.
  };
  struct Pixel {
    int x = 0;
    int y = 0;
    Content content = Content::kMixed;
    std::size_t probe = 0;  ///< The sample traced besides the centre to classify the content.
  };
  /// The tile's pixels that lie in the picture.
  [[nodiscard]] std::span<const std::size_t> filled() const noexcept { return filled_; }
  [[nodiscard]] const Pixel& pixel(std::size_t slot) const noexcept { return pixels_[slot]; }
  /// The ray through the pixel's centre. Its illumination is known unless the content is mixed.
  [[nodiscard]] const Sample& centre(std::size_t slot) const noexcept { return sample_of(slot, count_); }
  /// All samples of a mixed pixel.
  [[nodiscard]] std::span<Sample> samples(std::size_t slot) noexcept {
    return std::span(samples_).subspan(slot * (count_ + 1), count_);
  }
  /// Where the rays of the samples meet the pixel's triangle.
  [[nodiscard]] SurfaceStrip extrapolated(std::size_t slot) const;

 private:
  // Rays that wait for a full packet, and their samples.
  struct Queue {
    RayPacket packet;
    std::array<Sample*, RayPacket::kSize> samples{};
  };
  using Column = Eigen::Array<float, RayPacket::kSize, 1>;

  void place(int x0, int y0);
  [[nodiscard]] RayWorld::Reach reach_of_tile() const;
  void trace_centres();
  void trace_contents();
  void queue_ray(std::size_t slot, std::size_t index);
  void queue_samples(std::size_t slot);
  void aim_queue();
  void trace_queue();
  void locate(Sample& sample) const;
  void locate_samples(std::size_t slot);
  void find_triangles();
  [[nodiscard]] Content content_of(std::size_t slot);
  [[nodiscard]] bool shows_one_triangle(std::size_t slot) const;
  [[nodiscard]] bool shows_one_surface(std::size_t slot);
  void extrapolate_samples(std::size_t slot);
  void cast_shadows();
  void sample_shadow_edges();
  [[nodiscard]] Eigen::Vector3f scene_position(const Sample& sample) const;
  void queue_shadow(Sample& sample) { queue_shadow(sample, scene_position(sample)); }
  void queue_shadow(Sample& sample, const Eigen::Vector3f& scene_position);
  void trace_shadow_queue();

  [[nodiscard]] Sample& sample_of(std::size_t slot, std::size_t index) noexcept {
    return samples_[slot * (count_ + 1) + index];
  }
  [[nodiscard]] const Sample& sample_of(std::size_t slot, std::size_t index) const noexcept {
    return samples_[slot * (count_ + 1) + index];
  }
  [[nodiscard]] Sample& own_centre(std::size_t slot) noexcept { return sample_of(slot, count_); }
  [[nodiscard]] Sample& own_probe(std::size_t slot) noexcept { return sample_of(slot, pixels_[slot].probe); }
  [[nodiscard]] const Sample& probe(std::size_t slot) const noexcept { return sample_of(slot, pixels_[slot].probe); }
  static std::size_t probe_of(std::size_t slot) noexcept;

  Queue view_queue_;  // All rays start at the camera.
  Queue sun_queue_;
  Column queued_x_ = Column::Zero();  // Of the camera queue's rays, normalised image coordinates.
  Column queued_y_ = Column::Zero();
  TileGrid grid_;
  Eigen::Matrix3f R_scene_view_;
  Eigen::Vector3f origin_;
  Eigen::Vector3f to_sun_;
  Eigen::Vector2f principal_shift_;
  RayWorld::Reach reach_ = RayWorld::Reach::kEverything;  // Of the tile's rays.
  const RayWorld& world_;
  const SampleRays& rays_;
  std::size_t count_;  // Samples of a pixel.
  std::vector<Eigen::AlignedBox2f> actors_in_view_;
  std::array<Pixel, kTilePixels> pixels_{};
  std::vector<std::size_t> filled_;
  std::vector<Sample> samples_;    // Of each pixel its samples, then the centre: as SampleRays has them.
  std::vector<std::size_t> open_;  // Slots of pixels whose illumination is not known yet.
};

// Here so that it is inlined into its caller.
inline SurfaceStrip TileSampler::extrapolated(std::size_t slot) const {
  const Pixel& pixel = pixels_[slot];
  const Sample& known = centre(slot);
  const RayWorld::UvSlope& uv_slope = world_.parts()[0].uv_slopes[known.triangle];
  const Eigen::Vector3f from_view = known.distance * known.direction;
  const float height = known.face_normal.dot(from_view);
  const StripLanes x = StripLanes::Map(rays_.xs(pixel.x, pixel.y)) + principal_shift_.x();
  const StripLanes y = StripLanes::Map(rays_.ys(pixel.x, pixel.y)) + principal_shift_.y();
  const auto along = [&](int axis) -> StripLanes {
    return R_scene_view_(axis, 0) * x + R_scene_view_(axis, 1) * y + R_scene_view_(axis, 2);
  };
  const auto dot = [](const auto& a, const Strip3& b) -> StripLanes { return a[0] * b.x + a[1] * b.y + a[2] * b.z; };
  SurfaceStrip strip;
  strip.ray = {along(0), along(1), along(2)};
  const StripLanes distance = height / dot(known.face_normal, strip.ray);
  const Strip3 step{distance * strip.ray.x - from_view.x(), distance * strip.ray.y - from_view.y(),
                    distance * strip.ray.z - from_view.z()};
  strip.position = {step.x + known.local.position.x(), step.y + known.local.position.y(),
                    step.z + known.local.position.z()};
  strip.u = known.local.uv.x() + dot(uv_slope.row(0), step);
  strip.v = known.local.uv.y() + dot(uv_slope.row(1), step);
  return strip;
}

}  // namespace kinetrace::simulator
