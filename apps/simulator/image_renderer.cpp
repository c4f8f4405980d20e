#include "image_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "lighting.hpp"
#include "parallel.hpp"
#include "pixel_samples.hpp"
#include "surface.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

class TileRenderer {
 public:
  TileRenderer(const RayWorld& world, const SampleRays& rays, const EyePose& eye)
      : world_(world),
        light_(world.scene().light),
        texture_origin_(world.scene().texture_origin_m),
        to_sun_(light_.to_sun.normalized()),
        rays_(rays),
        sampler_(world, rays, eye) {}

  // Radiance of the tile whose upper left pixel is (x0, y0), added to `radiance`.
  void render(int x0, int y0, float weight, Image<float>& radiance) {
    sampler_.trace(x0, y0);
    for (const std::size_t slot : sampler_.filled()) {
      const TileSampler::Pixel& pixel = sampler_.pixel(slot);
      radiance.at(pixel.x, pixel.y) += weight * shade(slot);
    }
  }

  // What the rays through the centres met in the tile that was rendered last.
  void copy_truth(TruthImages& truth) const {
    for (const std::size_t slot : sampler_.filled()) {
      const TileSampler::Pixel& pixel = sampler_.pixel(slot);
      const Sample& centre = sampler_.centre(slot);
      if (centre.paint != nullptr) {
        // Rays have length one along the optical axis, so that distances are depths.
        truth.depth_m.at(pixel.x, pixel.y) = centre.distance;
        truth.actors.at(pixel.x, pixel.y) = world_.actor_label(centre.part);
      }
    }
  }

 private:
  [[nodiscard]] float shade(std::size_t slot) {
    const Sample& centre = sampler_.centre(slot);
    switch (sampler_.pixel(slot).content) {
      case TileSampler::Content::kMixed: return shade_mixed(sampler_.samples(slot));
      // A pixel that covers a long strip takes one texture sample for each of its rays.
      case TileSampler::Content::kTriangle:
        return is_elongated(centre) ? shade_continued(slot) : shade_together({&centre, 1});
      case TileSampler::Content::kSurface: return shade_together({&centre, 1});
    }
    return 0.F;
  }

  // A pixel of several surfaces: their samples are brought together and weighed by their number.
  [[nodiscard]] float shade_mixed(std::span<Sample> samples) const {
    const auto all = static_cast<float>(samples.size());
    float sum = 0.F;
    while (!samples.empty()) {
      const auto others =
          std::partition(samples.begin() + 1, samples.end(),
                         [first = samples.front()](const Sample& sample) { return alike(sample, first); });
      const auto count = static_cast<std::size_t>(others - samples.begin());
      const std::span<const Sample> group = samples.first(count);
      sum += static_cast<float>(count) * (is_elongated(group.front()) ? shade_each(group) : shade_together(group));
      samples = samples.subspan(count);
    }
    return sum / all;
  }

  [[nodiscard]] float shade_each(std::span<const Sample> group) const {
    const float footprint_m = strip_width_m(group.front());
    float sum = 0.F;
    for (const Sample& sample : group) {
      sum += shade(sample, sample.direction, sample.local, footprint_m);
    }
    return sum / static_cast<float>(group.size());
  }

  [[nodiscard]] float shade_continued(std::size_t slot) {
    const Sample& centre = sampler_.centre(slot);
    const float footprint_m = strip_width_m(centre);
    float sum = 0.F;
    for (const TileSampler::Continued& at : sampler_.continued(slot)) {
      sum += shade(centre, at.direction, at.local, footprint_m);
    }
    return sum / static_cast<float>(rays_.samples());
  }

  // Of the part of a long pixel that falls to each of its samples.
  [[nodiscard]] float strip_width_m(const Sample& sample) const {
    const float length = stretch_of(sample) / static_cast<float>(rays_.samples());
    return sample.distance * rays_.pixel_rad() * std::max(1.F, length);
  }

  [[nodiscard]] float shade_together(std::span<const Sample> group) const {
    Sample mean = group.front();
    if (mean.paint == nullptr) {
      return shade_sky(group);
    }
    for (const Sample& sample : group.subspan(1)) {
      mean.direction += sample.direction;
      mean.local.position += sample.local.position;
      mean.local.normal += sample.local.normal;
      mean.local.uv += sample.local.uv;
      mean.normal += sample.normal;
      mean.in_sun += sample.in_sun;
    }
    const auto count = static_cast<float>(group.size());
    mean.local.position /= count;
    mean.local.normal /= count;
    mean.local.uv /= count;
    mean.normal.normalize();
    mean.in_sun /= count;
    const float width_m = mean.distance * rays_.pixel_rad();
    return shade(mean, mean.direction, mean.local, 0.5F * width_m * (1.F + stretch_of(group.front())));
  }

  [[nodiscard]] float shade_sky(std::span<const Sample> group) const {
    Vector3f direction = Vector3f::Zero();
    for (const Sample& sample : group) {
      direction += sample.direction;
    }
    return sky_radiance(light_, direction.normalized());
  }

  // A point on the surface that `sample` met.
  [[nodiscard]] float shade(const Sample& sample, const Vector3f& direction, SurfacePoint point,
                            float footprint_m) const {
    point.footprint_m = footprint_m;
    if (sample.part == 0) {
      point.position += texture_origin_;
    }
    const Look look = look_of(*sample.paint, point);
    return shaded(light_, to_sun_, look, sample.normal, direction, sample.in_sun);
  }

  const RayWorld& world_;
  const Light& light_;
  Vector3f texture_origin_;
  Vector3f to_sun_;
  const SampleRays& rays_;
  TileSampler sampler_;
};

}  // namespace

void add_radiance(const RayWorld& world, const SampleRays& rays, const EyePose& eye, int threads, float weight,
                  Image<float>& radiance, TruthImages* truth) {
  const int columns = (rays.width() + kTileSide_px - 1) / kTileSide_px;
  const int rows = (rays.height() + kTileSide_px - 1) / kTileSide_px;
  for_each_index(rows, threads, [&](int row) {
    TileRenderer tile(world, rays, eye);
    for (int column = 0; column < columns; ++column) {
      tile.render(column * kTileSide_px, row * kTileSide_px, weight, radiance);
      if (truth != nullptr) {
        tile.copy_truth(*truth);
      }
    }
  });
}

}  // namespace kinetrace::simulator
