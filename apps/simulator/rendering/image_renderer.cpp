#include "rendering/image_renderer.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "rendering/pixel_samples.hpp"
#include "rendering/shading_queue.hpp"
#include "util/parallel.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

class TileRenderer {
 public:
  TileRenderer(const RayWorld& world, const SampleRays& rays, const ViewPose& view)
      : world_(world),
        texture_origin_(world.scene().texture_origin_m),
        rays_(rays),
        sampler_(world, rays, view),
        queue_(world.scene().light) {}

  // Radiance of the tile whose upper left pixel is (x0, y0), added to `radiance`.
  void render(int x0, int y0, float weight, Image<float>& radiance) {
    sampler_.trace(x0, y0);
    for (const std::size_t slot : sampler_.filled()) {
      const TileSampler::Pixel& pixel = sampler_.pixel(slot);
      shade(slot, {weight, radiance.at(pixel.x, pixel.y)});
    }
    queue_.finish();
  }

  // Copies the hits of the centre rays in the last rendered tile.
  void copy_truth(TruthImages& truth) const {
    for (const std::size_t slot : sampler_.filled()) {
      const TileSampler::Pixel& pixel = sampler_.pixel(slot);
      const Sample& centre = sampler_.centre(slot);
      if (centre.paint != nullptr) {
        // Rays have unit length along the optical axis, so that distances are depths.
        truth.depth_m.at(pixel.x, pixel.y) = centre.distance;
        truth.actors.at(pixel.x, pixel.y) = world_.actor_label(centre.part);
      }
    }
  }

 private:
  // A pixel, or a part of it, and the weight of its light.
  struct Share {
    float weight;
    float& pixel;

    [[nodiscard]] Share times(float factor) const noexcept { return {weight * factor, pixel}; }
  };

  void shade(std::size_t slot, const Share& share) {
    const TileSampler::Content content = sampler_.pixel(slot).content;
    if (content == TileSampler::Content::kMixed) {
      return shade_mixed(slot, share);
    }
    const Sample& centre = sampler_.centre(slot);
    if (centre.paint == nullptr) {
      return queue_.add_sky(centre.direction, share.weight, share.pixel);
    }
    // A pixel with a long footprint takes one texture sample for each of its rays.
    if (const float stretch = stretch_of(centre); content == TileSampler::Content::kTriangle && stretch > kElongated) {
      shade_extrapolated(slot, stretch, share);
    } else {
      const Sample* only = &centre;
      shade_together({&only, 1}, stretch, share);
    }
  }

  // Samples of one pixel.
  using Group = std::span<const Sample* const>;

  // A pixel of several surfaces: samples are grouped by surface and weighted by their number.
  void shade_mixed(std::size_t slot, const Share& share) {
    const std::span<const Sample> samples = sampler_.samples(slot);
    const Share each = share.times(1.F / static_cast<float>(samples.size()));
    std::array<const Sample*, kMaxSamples> sorted;  // Clearing it would take longer than filling it.
    std::transform(samples.begin(), samples.end(), sorted.begin(), [](const Sample& sample) { return &sample; });
    const auto end = sorted.begin() + samples.size();
    for (auto first = sorted.begin(); first != end;) {
      const auto others =
          std::partition(first + 1, end, [first](const Sample* sample) { return alike(*sample, **first); });
      shade_alike({first, others}, each);
      first = others;
    }
  }

  // `share` is that of one sample.
  void shade_alike(Group group, const Share& share) {
    const Share all = share.times(static_cast<float>(group.size()));
    if (group.front()->paint == nullptr) {
      return shade_sky(group, all);
    }
    if (const float stretch = stretch_of(*group.front()); stretch > kElongated) {
      shade_each(group, stretch, share);
    } else {
      shade_together(group, stretch, all);
    }
  }

  void shade_sky(Group group, const Share& share) {
    Vector3f direction = group.front()->direction;
    for (const Sample* sample : group.subspan(1)) {
      direction += sample->direction;
    }
    queue_.add_sky(direction, share.weight, share.pixel);
  }

  void shade_each(Group group, float stretch, const Share& share) {
    const float footprint_m = strip_width_m(*group.front(), stretch);
    for (const Sample* sample : group) {
      shade(*sample, {sample->local, footprint_m, sample->normal, sample->direction, sample->in_sun}, share);
    }
  }

  void shade_extrapolated(std::size_t slot, float stretch, const Share& share) {
    const Sample& centre = sampler_.centre(slot);
    SurfaceStrip strip = sampler_.extrapolated(slot);
    strip.position.x += texture_origin_.x();
    strip.position.y += texture_origin_.y();
    strip.position.z += texture_origin_.z();
    const Share each = share.times(1.F / static_cast<float>(kStripLanes));
    queue_.add_strip(*centre.paint,
                     {centre.local, strip_width_m(centre, stretch), centre.normal, centre.direction, centre.in_sun},
                     strip, each.weight, each.pixel);
  }

  // Size of the part of a long pixel's footprint that each of its samples covers.
  [[nodiscard]] float strip_width_m(const Sample& sample, float stretch) const {
    const float length = stretch / static_cast<float>(rays_.samples());
    return sample.distance * rays_.pixel_rad() * std::max(1.F, length);
  }

  void shade_together(Group group, float stretch, const Share& share) {
    const Sample& first = *group.front();
    const float width_m = first.distance * rays_.pixel_rad();
    ShadedPoint mean{first.local, 0.5F * width_m * (1.F + stretch), first.normal, first.direction, first.in_sun};
    for (const Sample* sample : group.subspan(1)) {
      mean.ray += sample->direction;
      mean.local.numbers() += sample->local.numbers();
      mean.normal += sample->normal;
      mean.in_sun += sample->in_sun;
    }
    if (group.size() > 1) {
      const auto count = static_cast<float>(group.size());
      mean.local.numbers() /= count;
      mean.in_sun /= count;
    }
    mean.normal.normalize();
    shade(first, mean, share);
  }

  // A point on the surface that `sample` hit.
  void shade(const Sample& sample, ShadedPoint point, const Share& share) {
    if (sample.part == 0) {
      point.local.position += texture_origin_;
    }
    queue_.add(*sample.paint, point, share.weight, share.pixel);
  }

  const RayWorld& world_;
  Vector3f texture_origin_;
  const SampleRays& rays_;
  TileSampler sampler_;
  ShadingQueue queue_;
};

}  // namespace

void add_radiance(const RayWorld& world, const SampleRays& rays, const ViewPose& view, int threads, float weight,
                  Image<float>& radiance, TruthImages* truth) {
  const int columns = (rays.width() + kTileSide_px - 1) / kTileSide_px;
  const int rows = (rays.height() + kTileSide_px - 1) / kTileSide_px;
  for_each_index(rows, threads, [&](int row) {
    TileRenderer tile(world, rays, view);
    for (int column = 0; column < columns; ++column) {
      tile.render(column * kTileSide_px, row * kTileSide_px, weight, radiance);
      if (truth != nullptr) {
        tile.copy_truth(*truth);
      }
    }
  });
}

}  // namespace kinetrace::simulator
