#include "image_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lighting.hpp"
#include "parallel.hpp"
#include "surface.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kTile_px = 16;
constexpr float kShadowOffset_m = 2e-3F;

// One ray of one pixel and what it met.
struct Sample {
  Vector3f direction;  // Scene frame; not of unit length.
  std::uint32_t part = RayPacket::kMiss;
  const Paint* paint = nullptr;
  float distance = 0.F;
  Vector3f scene_position;
  Vector3f face_normal;  // Of the triangle, scene frame, towards the viewer.
  Vector3f normal;       // Interpolated, scene frame.
  SurfacePoint local;    // In the part's frame.
  float in_sun = 0.F;
};

class TileRenderer {
 public:
  TileRenderer(const RayWorld& world, const SampleRays& rays, const Se3& T_scene_eye)
      : world_(world),
        rays_(rays),
        origin_(T_scene_eye.translation.cast<float>()),
        R_scene_eye_(T_scene_eye.rotation.cast<float>()),
        to_sun_(world.scene().light.to_sun.normalized()) {}

  // Radiance of the tile whose upper left pixel is (x0, y0), added to `radiance`.
  void render(int x0, int y0, float weight, Image<float>& radiance) {
    collect(x0, y0);
    trace();
    cast_shadows();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const auto& [x, y] = pixels_[i];
      radiance.at(x, y) += weight * shade_pixel(samples_of(i));
    }
  }

 private:
  // Pixels in small squares, so that the rays of a packet stay close together.
  void collect(int x0, int y0) {
    pixels_.clear();
    samples_.clear();
    for (int block = 0; block < kTile_px * kTile_px / 4; ++block) {
      for (int within = 0; within < 4; ++within) {
        const int x = x0 + 2 * (block % (kTile_px / 2)) + within % 2;
        const int y = y0 + 2 * (block / (kTile_px / 2)) + within / 2;
        if (x < rays_.width() && y < rays_.height()) {
          pixels_.push_back({x, y});
          for (int s = 0; s < rays_.samples(); ++s) {
            samples_.emplace_back().direction = R_scene_eye_ * rays_.at(x, y, s).homogeneous();
          }
        }
      }
    }
  }

  [[nodiscard]] std::span<Sample> samples_of(std::size_t pixel) {
    const auto count = static_cast<std::size_t>(rays_.samples());
    return std::span(samples_).subspan(pixel * count, count);
  }

  void trace() {
    for (std::size_t first = 0; first < samples_.size(); first += RayPacket::kSize) {
      const std::size_t count = std::min<std::size_t>(RayPacket::kSize, samples_.size() - first);
      RayPacket& packet = packet_;
      for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
        packet.active[i] = i < count ? -1 : 0;
        const Vector3f& direction = samples_[first + std::min(i, count - 1)].direction;
        set_ray(packet, i, origin_, direction);
      }
      world_.trace(packet);
      for (std::size_t i = 0; i < count; ++i) {
        if (packet.part[i] != RayPacket::kMiss) {
          locate(packet, i, samples_[first + i]);
        }
      }
    }
  }

  static void set_ray(RayPacket& packet, std::size_t i, const Vector3f& origin, const Vector3f& direction) {
    packet.origin_x[i] = origin.x();
    packet.origin_y[i] = origin.y();
    packet.origin_z[i] = origin.z();
    packet.direction_x[i] = direction.x();
    packet.direction_y[i] = direction.y();
    packet.direction_z[i] = direction.z();
  }

  void locate(const RayPacket& packet, std::size_t i, Sample& sample) const {
    const RayWorld::Part& part = world_.parts()[packet.part[i]];
    const Mesh::Triangle& triangle = part.mesh->triangles[packet.triangle[i]];
    const RayWorld::Face& face = part.faces[packet.triangle[i]];
    const Mesh::Vertex& a = part.mesh->vertices[triangle.corners[0]];
    const Mesh::Vertex& b = part.mesh->vertices[triangle.corners[1]];
    const Mesh::Vertex& c = part.mesh->vertices[triangle.corners[2]];
    const float u = packet.u[i];
    const float v = packet.v[i];
    const float w = 1.F - u - v;
    sample.part = packet.part[i];
    sample.paint = &triangle.paint;
    sample.distance = packet.distance[i];
    sample.local.position = w * a.position + u * b.position + v * c.position;
    sample.local.uv = w * a.uv + u * b.uv + v * c.uv;
    sample.local.normal = face.flat ? face.normal : (w * a.normal + u * b.normal + v * c.normal).normalized();
    sample.scene_position = origin_ + sample.distance * sample.direction;
    // The static world's frame is the scene's.
    const bool turned = sample.part != 0;
    sample.face_normal = turned ? Vector3f(part.R_scene_part * face.normal) : face.normal;
    if (sample.face_normal.dot(sample.direction) > 0.F) {
      sample.face_normal = -sample.face_normal;
    }
    if (face.flat) {
      sample.normal = sample.face_normal;
      return;
    }
    sample.normal = turned ? Vector3f(part.R_scene_part * sample.local.normal) : sample.local.normal;
    if (sample.normal.dot(sample.face_normal) < 0.F) {
      sample.normal = -sample.normal;
    }
  }

  static bool alike(const Sample& a, const Sample& b) {
    if (a.paint == nullptr || b.paint == nullptr) {
      return a.paint == b.paint;
    }
    return a.part == b.part && a.paint->material == b.paint->material && a.paint->seed == b.paint->seed &&
           a.normal.dot(b.normal) > 0.95F;
  }

  // More than two samples, all alike.
  static bool one_surface(std::span<const Sample> pixel) {
    return pixel.size() > 2 &&
           std::all_of(pixel.begin(), pixel.end(), [&](const Sample& sample) { return alike(sample, pixel.front()); });
  }

  // Where the first and the last sample of a surface agree, those between agree too: half the rays, same picture but
  // for slivers.
  void cast_shadows() {
    queue_.clear();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const std::span<Sample> pixel = samples_of(i);
      if (one_surface(pixel)) {
        queue(pixel.front());
        queue(pixel.back());
      } else {
        std::for_each(pixel.begin(), pixel.end(), [&](Sample& sample) { queue(sample); });
      }
    }
    trace_queue();
    queue_.clear();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const std::span<Sample> pixel = samples_of(i);
      if (one_surface(pixel)) {
        const bool agree = pixel.front().in_sun == pixel.back().in_sun;
        for (Sample& sample : pixel.subspan(1, pixel.size() - 2)) {
          if (agree) {
            sample.in_sun = pixel.front().in_sun;
          } else {
            queue(sample);
          }
        }
      }
    }
    trace_queue();
  }

  void queue(Sample& sample) {
    if (sample.paint != nullptr && sample.face_normal.dot(to_sun_) > 0.F && sample.normal.dot(to_sun_) > 0.F) {
      queue_.push_back(&sample);
    }
  }

  void trace_queue() {
    for (std::size_t first = 0; first < queue_.size(); first += RayPacket::kSize) {
      const std::size_t count = std::min<std::size_t>(RayPacket::kSize, queue_.size() - first);
      RayPacket& packet = packet_;
      for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
        packet.active[i] = i < count ? -1 : 0;
        const Sample& sample = *queue_[first + std::min(i, count - 1)];
        set_ray(packet, i, sample.scene_position + kShadowOffset_m * sample.face_normal, to_sun_);
      }
      world_.trace_shadow(packet);
      for (std::size_t i = 0; i < count; ++i) {
        queue_[first + i]->in_sun = packet.blocked[i] ? 0.F : 1.F;
      }
    }
  }

  [[nodiscard]] float shade_pixel(std::span<Sample> samples) const {
    float sum = 0.F;
    std::span<Sample> open = samples;
    // Samples on the same surface are brought to the front and shaded together; most pixels see only one.
    while (!open.empty()) {
      std::size_t count = 1;
      for (std::size_t i = 1; i < open.size(); ++i) {
        if (alike(open[i], open.front())) {
          if (i != count) {
            std::swap(open[i], open[count]);
          }
          ++count;
        }
      }
      const std::span<Sample> group = open.first(count);
      sum += group.front().paint == nullptr ? sky(group) : shade_group(group);
      open = open.subspan(count);
    }
    return sum / static_cast<float>(samples.size());
  }

  // The sum over the group.
  [[nodiscard]] float sky(std::span<const Sample> group) const {
    Vector3f direction = Vector3f::Zero();
    for (const Sample& sample : group) {
      direction += sample.direction;
    }
    return static_cast<float>(group.size()) * sky_radiance(world_.scene().light, direction.normalized());
  }

  [[nodiscard]] float shade_group(std::span<const Sample> group) const {
    constexpr float kElongated = 1.8F;
    const Sample& first = group.front();
    const float minor_m = first.distance * rays_.pixel_rad();
    const float facing = std::abs(first.face_normal.dot(first.direction)) / first.direction.norm();
    const float stretch = 1.F / std::max(facing, 0.02F);
    if (stretch > kElongated) {
      // A pixel that covers a long strip takes one texture sample for each of its rays.
      const float footprint_m = minor_m * std::max(1.F, stretch / static_cast<float>(rays_.samples()));
      float sum = 0.F;
      for (const Sample& sample : group) {
        sum += shade(sample, footprint_m);
      }
      return sum;
    }
    Sample mean = first;
    for (const Sample& sample : group.subspan(1)) {
      mean.local.position += sample.local.position;
      mean.local.normal += sample.local.normal;
      mean.local.uv += sample.local.uv;
      mean.normal += sample.normal;
      mean.direction += sample.direction;
      mean.in_sun += sample.in_sun;
    }
    const auto count = static_cast<float>(group.size());
    mean.local.position /= count;
    mean.local.normal /= count;
    mean.local.uv /= count;
    mean.normal.normalize();
    mean.in_sun /= count;
    return count * shade(mean, 0.5F * minor_m * (1.F + stretch));
  }

  [[nodiscard]] float shade(const Sample& sample, float footprint_m) const {
    SurfacePoint point = sample.local;
    point.footprint_m = footprint_m;
    const Look look = look_of(*sample.paint, point);
    return shaded(world_.scene().light, to_sun_, look, sample.normal, sample.direction.normalized(), sample.in_sun);
  }

  const RayWorld& world_;
  const SampleRays& rays_;
  Vector3f origin_;
  Eigen::Matrix3f R_scene_eye_;
  Vector3f to_sun_;
  RayPacket packet_;
  std::vector<std::array<int, 2>> pixels_;
  std::vector<Sample> samples_;
  std::vector<Sample*> queue_;  // Samples whose ray to the sun is to be traced.
};

}  // namespace

void add_radiance(const RayWorld& world, const SampleRays& rays, const Se3& T_scene_eye, int threads, float weight,
                  Image<float>& radiance) {
  const int columns = (rays.width() + kTile_px - 1) / kTile_px;
  const int rows = (rays.height() + kTile_px - 1) / kTile_px;
  for_each_index(rows, threads, [&](int row) {
    TileRenderer tile(world, rays, T_scene_eye);
    for (int column = 0; column < columns; ++column) {
      tile.render(column * kTile_px, row * kTile_px, weight, radiance);
    }
  });
}

}  // namespace kinetrace::simulator
