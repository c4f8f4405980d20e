#include "rendering/pixel_samples.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

constexpr float kShadowOffset_m = 2e-3F;

// If pixels have this many samples, one of them is a probe, and the others can be extrapolated from the centre.
constexpr std::size_t kProbedCount = kStripLanes;

// Result of find_triangles() for pixels without a single triangle; above the indices of triangles.
constexpr std::uint32_t kSeveral = TileGrid::kOutside - 1;
constexpr std::uint32_t kSky = TileGrid::kOutside - 2;

}  // namespace

TileSampler::TileSampler(const RayWorld& world, const SampleRays& rays, const ViewPose& view)
    : R_scene_view_(view.T_scene_view.rotation.cast<float>()),
      origin_(view.T_scene_view.translation.cast<float>()),
      to_sun_(world.scene().light.to_sun.normalized()),
      principal_shift_(view.principal_shift),
      world_(world),
      rays_(rays),
      count_(static_cast<std::size_t>(rays.samples())),
      actors_in_view_(world.actors_in_view(view.T_scene_view)),
      samples_(kTilePixels * (count_ + 1)) {
  for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
    view_queue_.packet.set_origin(i, origin_);
  }
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    pixels_[slot].probe = probe_of(slot);
  }
}

// One sample, besides the centre, probes the pixel's content. The probe alternates within squares of two by two pixels,
// so that neither rows nor columns leave a gap of more than half a pixel, which could hide a line.
std::size_t TileSampler::probe_of(std::size_t slot) noexcept {
  constexpr std::array<std::array<std::size_t, 2>, 2> kTurns{{{1, 3}, {2, 0}}};
  const auto& [x, y] = kTileOrder[slot];
  return kTurns[static_cast<std::size_t>(y % 2)][static_cast<std::size_t>(x % 2)];
}

void TileSampler::trace(int x0, int y0) {
  place(x0, y0);
  reach_ = reach_of_tile();
  trace_centres();
  trace_contents();
  cast_shadows();
}

void TileSampler::place(int x0, int y0) {
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    pixels_[slot].x = x0 + kTileOrder[slot][0];
    pixels_[slot].y = y0 + kTileOrder[slot][1];
  }
  const bool whole = x0 + kTileSide_px <= rays_.width() && y0 + kTileSide_px <= rays_.height();
  if (whole && filled_.size() == kTilePixels) {
    return;
  }
  filled_.clear();
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    if (pixels_[slot].x < rays_.width() && pixels_[slot].y < rays_.height()) {
      filled_.push_back(slot);
    }
  }
}

// Traces centres and probes together: they are so close that they take the same path through the tree.
void TileSampler::trace_centres() {
  for (const std::size_t slot : filled_) {
    queue_ray(slot, count_);
    if (count_ == kProbedCount) {
      queue_ray(slot, pixels_[slot].probe);
    }
  }
  trace_queue();
  for (const std::size_t slot : filled_) {
    locate(own_centre(slot));
  }
}

// Most tiles show no actor and have none nearby.
RayWorld::Reach TileSampler::reach_of_tile() const {
  const int x0 = pixels_.front().x;
  const int y0 = pixels_.front().y;
  const int x1 = std::min(x0 + kTileSide_px, rays_.width()) - 1;
  const int y1 = std::min(y0 + kTileSide_px, rays_.height()) - 1;
  // A distorting lens may bend the tile, but its border still encloses its interior.
  Eigen::AlignedBox2f tile;
  for (int x = x0; x <= x1; ++x) {
    tile.extend(rays_.centre(x, y0)).extend(rays_.centre(x, y1));
  }
  for (int y = y0; y <= y1; ++y) {
    tile.extend(rays_.centre(x0, y)).extend(rays_.centre(x1, y));
  }
  tile.translate(principal_shift_);
  // Samples lie half a pixel from the centre, or slightly more at the edge of a distorting lens.
  const Eigen::Vector2f margin = Eigen::Vector2f::Constant(2.F * rays_.pixel_rad());
  tile.min() -= margin;
  tile.max() += margin;
  const bool near_actor = std::any_of(actors_in_view_.begin(), actors_in_view_.end(),
                                      [&](const Eigen::AlignedBox2f& view) { return view.intersects(tile); });
  return near_actor ? RayWorld::Reach::kEverything : RayWorld::Reach::kStaticWorld;
}

// Classifies the pixels, and traces the samples of mixed ones.
void TileSampler::trace_contents() {
  if (count_ == kProbedCount) {
    find_triangles();
  }
  for (const std::size_t slot : filled_) {
    Pixel& pixel = pixels_[slot];
    pixel.content = content_of(slot);
    if (pixel.content == Content::kMixed) {
      queue_samples(slot);
    }
  }
  trace_queue();
  for (const std::size_t slot : filled_) {
    if (pixels_[slot].content == Content::kMixed) {
      locate_samples(slot);
    }
  }
}

void TileSampler::locate_samples(std::size_t slot) {
  for (Sample& sample : samples(slot)) {
    locate(sample);
  }
}

void TileSampler::queue_ray(std::size_t slot, std::size_t index) {
  const Pixel& pixel = pixels_[slot];
  RayPacket& packet = view_queue_.packet;
  const auto place = static_cast<Eigen::Index>(packet.count);
  queued_x_[place] = rays_.xs(pixel.x, pixel.y)[index];
  queued_y_[place] = rays_.ys(pixel.x, pixel.y)[index];
  view_queue_.samples[packet.count] = &sample_of(slot, index);
  if (++packet.count == RayPacket::kSize) {
    trace_queue();
  }
}

void TileSampler::queue_samples(std::size_t slot) {
  for (std::size_t s = 0; s < count_; ++s) {
    if (count_ != kProbedCount || s != pixels_[slot].probe) {
      queue_ray(slot, s);
    }
  }
}

TileSampler::Content TileSampler::content_of(std::size_t slot) {
  if (count_ != kProbedCount) {
    return Content::kMixed;
  }
  return shows_one_triangle(slot) ? Content::kTriangle : shows_one_surface(slot) ? Content::kSurface : Content::kMixed;
}

// The triangle of the static world, or the sky, that both the centre and the probe of a pixel hit.
void TileSampler::find_triangles() {
  grid_.clear();
  for (const std::size_t slot : filled_) {
    const Sample& first = centre(slot);
    const Sample& second = probe(slot);
    const bool same = first.triangle == second.triangle && first.part == second.part;
    const bool sky = first.part == RayPacket::kMiss;
    grid_.set(slot, same && first.part == 0 ? first.triangle : same && sky ? kSky : kSeveral);
  }
  grid_.compare();
}

// Whether the pixel shows one flat triangle of the static world, or only sky. Triangles are convex: rays between rays
// that hit a triangle hit it too, unless an object thinner than the gaps between them stands in front.
bool TileSampler::shows_one_triangle(std::size_t slot) const {
  const std::uint32_t triangle = grid_.at(slot);
  if (triangle == kSeveral || !grid_.is_steady(slot)) {
    return false;
  }
  // Samples beyond the triangle's edge are extrapolated in its plane, except near the horizon, where a ray may miss the
  // plane.
  const Sample& first = centre(slot);
  return triangle == kSky || (world_.parts()[0].facets[triangle].flat &&
                              std::abs(first.face_normal.dot(first.direction)) > 0.01F * first.direction.norm());
}

bool TileSampler::shows_one_surface(std::size_t slot) {
  const Sample& first = centre(slot);
  return first.paint != nullptr && !(stretch_of(first) > kElongated) && grid_.agree_around(slot, [&](std::size_t at) {
    locate(own_probe(at));
    return alike(centre(at), first) && alike(probe(at), first);
  });
}

// Extrapolates the samples on a triangle, for individual shadow rays.
void TileSampler::extrapolate_samples(std::size_t slot) {
  const Sample& known = centre(slot);
  const SurfaceStrip strip = extrapolated(slot);
  for (std::size_t s = 0; s < count_; ++s) {
    Sample& sample = samples(slot)[s];
    sample = known;
    sample.direction = strip.ray.at(s);
    sample.local.position = strip.position.at(s);
    sample.local.uv = strip.uv_at(s);
  }
}

// Computes the directions of all rays at once, queued or not.
void TileSampler::aim_queue() {
  const Column x = queued_x_ + principal_shift_.x();
  const Column y = queued_y_ + principal_shift_.y();
  RayPacket& packet = view_queue_.packet;
  const std::array<float*, 3> along{packet.direction_x.data(), packet.direction_y.data(), packet.direction_z.data()};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Column::Map(along[static_cast<std::size_t>(axis)]) =
        R_scene_view_(axis, 0) * x + R_scene_view_(axis, 1) * y + R_scene_view_(axis, 2);
  }
}

void TileSampler::trace_queue() {
  aim_queue();
  RayPacket& packet = view_queue_.packet;
  world_.trace(packet, reach_);
  for (std::size_t i = 0; i < packet.count; ++i) {
    Sample& sample = *view_queue_.samples[i];
    sample.direction = {packet.direction_x[i], packet.direction_y[i], packet.direction_z[i]};
    sample.paint = nullptr;
    sample.in_sun = 0.F;
    sample.part = packet.part[i];
    sample.triangle = packet.triangle[i];
    sample.distance = packet.distance[i];
    sample.u = packet.u[i];
    sample.v = packet.v[i];
  }
  packet.count = 0;
}

// Computes position, normal and uv; once for each sample.
void TileSampler::locate(Sample& sample) const {
  if (sample.paint != nullptr || sample.part == RayPacket::kMiss) {
    return;
  }
  const RayWorld::Part& part = world_.parts()[sample.part];
  const RayWorld::Facet& facet = part.facets[sample.triangle];
  const auto& [a, b, c] = facet.corners;
  const float u = sample.u;
  const float v = sample.v;
  const float w = 1.F - u - v;
  sample.paint = &facet.paint;
  // Position, normal and uv at once.
  sample.local.numbers() = w * a.numbers() + u * b.numbers() + v * c.numbers();
  sample.local.normal = facet.flat ? facet.normal : sample.local.normal.normalized();
  // The static world's frame is the scene's.
  const bool turned = sample.part != 0;
  sample.face_normal = turned ? Vector3f(part.R_scene_part * facet.normal) : facet.normal;
  if (sample.face_normal.dot(sample.direction) > 0.F) {
    sample.face_normal = -sample.face_normal;
  }
  if (facet.flat) {
    sample.normal = sample.face_normal;
    return;
  }
  sample.normal = turned ? Vector3f(part.R_scene_part * sample.local.normal) : sample.local.normal;
  if (sample.normal.dot(sample.face_normal) < 0.F) {
    sample.normal = -sample.normal;
  }
}

// One ray to the sun for a pixel of one surface. In a mixed pixel with similar samples, the others follow if the first
// and the last agree.
void TileSampler::cast_shadows() {
  open_.clear();
  for (const std::size_t slot : filled_) {
    const std::span<Sample> all = samples(slot);
    if (pixels_[slot].content != Content::kMixed) {
      queue_shadow(own_centre(slot));
    } else if (std::all_of(all.begin() + 1, all.end(),
                           [&](const Sample& other) { return alike(other, all.front()); })) {
      queue_shadow(all.front());
      queue_shadow(all.back());
      open_.push_back(slot);
    } else {
      std::for_each(all.begin(), all.end(), [&](Sample& sample) { queue_shadow(sample); });
    }
  }
  trace_shadow_queue();
  for (const std::size_t slot : open_) {
    const std::span<Sample> all = samples(slot);
    for (Sample& sample : all.subspan(1, std::max<std::size_t>(count_, 2) - 2)) {
      if (all.front().in_sun == all.back().in_sun) {
        sample.in_sun = all.front().in_sun;
      } else {
        queue_shadow(sample);
      }
    }
  }
  trace_shadow_queue();
  sample_shadow_edges();
}

// At shadow edges, where neighbouring pixels of a surface disagree, all samples cast shadow rays.
void TileSampler::sample_shadow_edges() {
  open_.clear();
  grid_.clear();
  std::size_t lit = 0;
  for (const std::size_t slot : filled_) {
    const Sample& shown = pixels_[slot].content == Content::kMixed ? samples(slot).front() : centre(slot);
    const std::uint32_t in_sun = shown.in_sun > 0.F ? 1U : 0U;
    grid_.set(slot, in_sun);
    lit += in_sun;
  }
  if (lit == 0 || lit == filled_.size()) {
    return;
  }
  grid_.compare();
  for (const std::size_t slot : filled_) {
    if (pixels_[slot].content != Content::kMixed && centre(slot).paint != nullptr && !grid_.is_steady(slot)) {
      open_.push_back(slot);
    }
  }
  for (const std::size_t slot : open_) {
    if (pixels_[slot].content == Content::kSurface) {
      queue_samples(slot);
    } else {
      extrapolate_samples(slot);
    }
  }
  trace_queue();
  for (const std::size_t slot : open_) {
    locate_samples(slot);
    for (Sample& sample : samples(slot)) {
      // The extrapolated ones lie in the triangle's plane to the last bit.
      if (pixels_[slot].content == Content::kTriangle) {
        queue_shadow(sample, sample.local.position);
      } else {
        queue_shadow(sample);
      }
    }
    pixels_[slot].content = Content::kMixed;
  }
  trace_shadow_queue();
}

Vector3f TileSampler::scene_position(const Sample& sample) const {
  return origin_ + sample.distance * sample.direction;
}

void TileSampler::queue_shadow(Sample& sample, const Vector3f& scene_position) {
  if (sample.paint == nullptr || !(sample.face_normal.dot(to_sun_) > 0.F) || !(sample.normal.dot(to_sun_) > 0.F)) {
    return;
  }
  RayPacket& packet = sun_queue_.packet;
  packet.set_origin(packet.count, scene_position + kShadowOffset_m * sample.face_normal);
  sun_queue_.samples[packet.count] = &sample;
  if (++packet.count == RayPacket::kSize) {
    trace_shadow_queue();
  }
}

void TileSampler::trace_shadow_queue() {
  RayPacket& packet = sun_queue_.packet;
  world_.trace_shadow(packet);
  for (std::size_t i = 0; i < packet.count; ++i) {
    sun_queue_.samples[i]->in_sun = packet.blocked[i] ? 0.F : 1.F;
  }
  packet.count = 0;
}

}  // namespace kinetrace::simulator
