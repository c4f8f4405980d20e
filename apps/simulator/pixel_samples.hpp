// What the rays of a small square of pixels meet.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "camera_rig.hpp"
#include "ray_world.hpp"
#include "surface.hpp"
#include "surface_pack.hpp"
#include "tile_grid.hpp"

namespace kinetrace::simulator {

/// One ray of one pixel and what it met.
struct Sample {
  Eigen::Vector3f direction;              ///< Scene frame; not of unit length.
  std::uint32_t part = RayPacket::kMiss;  ///< Index into RayWorld::parts().
  std::uint32_t triangle = RayPacket::kMiss;
  const Paint* paint = nullptr;  ///< None for the sky.
  float distance = 0.F;          ///< In units of the direction's length.
  float u = 0.F;                 ///< Barycentric coordinates of the triangle's second and third corner.
  float v = 0.F;
  float in_sun = 0.F;    ///< 1 where nothing stands between the surface and the sun.
  bool located = false;  ///< What follows is known.
  Eigen::Vector3f scene_position;
  Eigen::Vector3f face_normal;  ///< Of the triangle, scene frame, towards the viewer.
  Eigen::Vector3f normal;       ///< Interpolated, scene frame.
  SurfacePoint local;           ///< In the part's frame.
};

/// On the same smooth piece of the same surface.
[[nodiscard]] inline bool alike(const Sample& a, const Sample& b) {
  if (a.paint == nullptr || b.paint == nullptr) {
    return a.paint == b.paint;
  }
  return a.part == b.part && a.paint->material == b.paint->material && a.paint->seed == b.paint->seed &&
         a.normal.dot(b.normal) > 0.95F;
}

/// How many times as long as wide a pixel is on the sample's surface.
[[nodiscard]] inline float stretch_of(const Sample& sample) {
  const float facing = std::abs(sample.face_normal.dot(sample.direction)) / sample.direction.norm();
  return 1.F / std::max(facing, 0.02F);
}

/// A pixel that is longer on the surface covers a strip that one texture sample cannot stand for.
inline constexpr float kElongated = 1.8F;

/// Traces tile by tile. A pixel is the mean of its samples; where the rays through its centre and through one sample,
/// and those of its neighbours, tell that the samples would all meet the same, they are not traced one by one.
/// Holds working memory: one for each thread.
class TileSampler {
 public:
  /// All must outlive the sampler.
  TileSampler(const RayWorld& world, const SampleRays& rays, const EyePose& eye);

  /// Traces and shadows the tile whose upper left pixel is (x0, y0).
  void trace(int x0, int y0);

  enum class Content {
    kTriangle,  ///< One flat triangle of the static world, or the sky: the samples follow from the centre.
    kSurface,   ///< One smooth surface seen from the front: the centre stands for the samples.
    kMixed,     ///< Anything: the samples have been traced.
  };
  struct Pixel {
    int x = 0;
    int y = 0;
    Content content = Content::kMixed;
    std::size_t probe = 0;  ///< The sample that is traced besides the centre to tell the content.
  };
  /// The tile's pixels that lie in the picture.
  [[nodiscard]] std::span<const std::size_t> filled() const noexcept { return filled_; }
  [[nodiscard]] const Pixel& pixel(std::size_t slot) const noexcept { return pixels_[slot]; }
  /// The ray through the pixel's centre. What light falls there is known unless the content is mixed.
  [[nodiscard]] const Sample& centre(std::size_t slot) const noexcept { return samples_[slot * (count_ + 1)]; }
  /// All samples of a mixed pixel.
  [[nodiscard]] std::span<Sample> samples(std::size_t slot) noexcept {
    return std::span(samples_).subspan(slot * (count_ + 1) + 1, count_);
  }
  /// Where the rays of the samples meet the triangle that a pixel shows.
  [[nodiscard]] SurfaceStrip continued(std::size_t slot) const;

 private:
  // Rays that wait for a packet to be full, and the samples that they are for.
  struct Queue {
    RayPacket packet;
    std::array<Sample*, RayPacket::kSize> samples{};
  };

  void place(int x0, int y0);
  [[nodiscard]] RayWorld::Reach reach_of_tile() const;
  void trace_centres();
  void trace_contents();
  void queue_ray(const Eigen::Vector2f& ray, Sample& sample);
  void queue_sample(std::size_t slot, std::size_t index);
  void queue_samples(std::size_t slot);
  void trace_queue();
  void locate(Sample& sample) const;
  void locate_samples(std::size_t slot);
  void find_triangles();
  [[nodiscard]] Content content_of(std::size_t slot);
  [[nodiscard]] bool shows_one_triangle(std::size_t slot) const;
  [[nodiscard]] bool shows_one_surface(std::size_t slot);
  void continue_samples(std::size_t slot);
  void cast_shadows();
  void sample_shadow_edges();
  void queue_shadow(Sample& sample);
  void trace_shadow_queue();

  [[nodiscard]] Sample& own_centre(std::size_t slot) noexcept { return samples_[slot * (count_ + 1)]; }
  [[nodiscard]] Sample& sample_of(std::size_t slot, std::size_t index) noexcept {
    return samples_[slot * (count_ + 1) + 1 + index];
  }
  [[nodiscard]] Sample& own_probe(std::size_t slot) noexcept { return sample_of(slot, pixels_[slot].probe); }
  [[nodiscard]] const Sample& probe(std::size_t slot) const noexcept {
    return samples_[slot * (count_ + 1) + 1 + pixels_[slot].probe];
  }
  static std::size_t probe_of(std::size_t slot) noexcept;

  Queue eye_queue_;  // All rays start at the eye.
  Queue sun_queue_;
  TileGrid grid_;
  Eigen::Array<float, 4, 3> R_scene_eye_ = Eigen::Array<float, 4, 3>::Zero();  // Three rows; four go at once.
  const RayWorld& world_;
  const SampleRays& rays_;
  std::size_t count_;  // Samples of a pixel.
  Eigen::Vector3f origin_;
  Eigen::Vector2f principal_shift_;
  Eigen::Vector3f to_sun_;
  std::vector<Eigen::AlignedBox2f> actors_in_view_;
  RayWorld::Reach reach_ = RayWorld::Reach::kEverything;  // Of the tile's rays.
  std::array<Pixel, kTilePixels> pixels_{};
  std::vector<std::size_t> filled_;
  std::vector<Sample> samples_;    // Of each pixel the centre, then its samples.
  std::vector<std::size_t> open_;  // Slots of pixels whose light is not known yet.
};

}  // namespace kinetrace::simulator
