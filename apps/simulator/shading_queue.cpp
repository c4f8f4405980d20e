#include "shading_queue.hpp"

#include <algorithm>

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::simulator {
namespace {

bool same_look(const Paint& a, const Paint& b) {
  return a.material == b.material && a.seed == b.seed && a.shape == b.shape;
}

Daylight daylight_of(const Light& light) {
  const Eigen::Vector3f to_sun = light.to_sun.normalized();
  return {{to_sun.x(), to_sun.y(), to_sun.z()}, light.sun, light.ambient, light.sky};
}

}  // namespace

const ShadingKernel& shading_kernel() {
#ifdef KINETRACE_HAVE_V3
  if (cpu_has_v3()) {
    return kernel_v3::shading_kernel;
  }
#endif
  return kernel_baseline::shading_kernel;
}

ShadingQueue::ShadingQueue(const Light& light) : kernel_(shading_kernel()), light_(daylight_of(light)) {}

std::size_t ShadingQueue::Targets::add(float weight, float& pixel) {
  pixels[count] = &pixel;
  weights[count] = weight;
  return count++;
}

void ShadingQueue::Targets::receive(const Lanes& radiance) {
  for (std::size_t i = 0; i < count; ++i) {
    *pixels[i] += weights[i] * radiance[i];
  }
  count = 0;
}

ShadingQueue::Group& ShadingQueue::group_of(const Paint& paint) {
  std::size_t& recent = recent_[(static_cast<std::size_t>(paint.material) + 5U * paint.seed) % recent_.size()];
  if (recent < used_ && same_look(*groups_[recent].paint, paint)) {
    return groups_[recent];
  }
  const auto end = groups_.begin() + static_cast<std::ptrdiff_t>(used_);
  const auto known =
      std::find_if(groups_.begin(), end, [&](const Group& group) { return same_look(*group.paint, paint); });
  recent = static_cast<std::size_t>(known - groups_.begin());
  if (known == end) {
    if (++used_ > groups_.size()) {
      groups_.emplace_back();
    }
    groups_[recent].paint = &paint;
  }
  return groups_[recent];
}

void ShadingQueue::add(const Paint& paint, const ShadedPoint& point, float weight, float& pixel) {
  Group& group = group_of(paint);
  const std::size_t lane = group.targets.add(weight, pixel);
  SurfacePack& pack = group.pack;
  pack.position.set(lane, point.local.position);
  pack.normal.set(lane, point.local.normal);
  pack.u[lane] = point.local.uv.x();
  pack.v[lane] = point.local.uv.y();
  pack.footprint_m[lane] = point.footprint_m;
  pack.scene_normal.set(lane, point.normal);
  pack.ray.set(lane, point.ray);
  pack.in_sun[lane] = point.in_sun;
  if (group.targets.full()) {
    shade(group);
  }
}

void ShadingQueue::add_sky(const Eigen::Vector3f& direction, float weight, float& pixel) {
  sky_directions_.set(sky_targets_.add(weight, pixel), direction);
  if (sky_targets_.full()) {
    shade_sky();
  }
}

void ShadingQueue::finish() {
  for (std::size_t i = 0; i < used_; ++i) {
    if (groups_[i].targets.count > 0) {
      shade(groups_[i]);
    }
  }
  used_ = 0;
  if (sky_targets_.count > 0) {
    shade_sky();
  }
}

void ShadingQueue::shade(Group& group) {
  Lanes radiance;
  kernel_.shade(*group.paint, group.pack, light_, radiance);
  group.targets.receive(radiance);
}

void ShadingQueue::shade_sky() {
  Lanes radiance;
  kernel_.shade_sky(sky_directions_, light_, radiance);
  sky_targets_.receive(radiance);
}

}  // namespace kinetrace::simulator
