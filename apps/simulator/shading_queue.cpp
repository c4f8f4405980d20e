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
  return cpu_runs_fast_kernels() ? kernel_fast::shading_kernel : kernel_baseline::shading_kernel;
}

ShadingQueue::ShadingQueue(const Light& light) : kernel_(shading_kernel()), light_(daylight_of(light)) {}

std::size_t ShadingQueue::Targets::add(std::size_t lanes, float weight, float& pixel) {
  const std::size_t first = count;
  for (; count < first + lanes; ++count) {
    pixels[count] = &pixel;
    weights[count] = weight;
  }
  return first;
}

void ShadingQueue::Targets::receive(const Lanes& radiance) {
  for (std::size_t i = 0; i < count; ++i) {
    *pixels[i] += weights[i] * radiance[i];
  }
  count = 0;
}

ShadingQueue::Group& ShadingQueue::group_of(const Paint& paint, bool strips) {
  const auto belongs = [&](const Group& group) { return group.strips == strips && same_look(*group.paint, paint); };
  const std::size_t hash = 2U * (static_cast<std::size_t>(paint.material) + 5U * paint.seed) + (strips ? 1U : 0U);
  std::size_t& recent = recent_[hash % recent_.size()];
  if (recent < used_ && belongs(groups_[recent])) {
    return groups_[recent];
  }
  const auto end = groups_.begin() + static_cast<std::ptrdiff_t>(used_);
  const auto known = std::find_if(groups_.begin(), end, belongs);
  recent = static_cast<std::size_t>(known - groups_.begin());
  if (known == end) {
    if (++used_ > groups_.size()) {
      groups_.emplace_back();
    }
    groups_[recent].paint = &paint;
    groups_[recent].strips = strips;
  }
  return groups_[recent];
}

void ShadingQueue::add(const Paint& paint, const ShadedPoint& point, float weight, float& pixel) {
  Group& group = group_of(paint, false);
  const std::size_t lane = group.targets.add(1, weight, pixel);
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

void ShadingQueue::add_strip(const Paint& paint, const ShadedPoint& point, const SurfaceStrip& strip, float weight,
                             float& pixel) {
  Group& group = group_of(paint, true);
  const std::size_t lane = group.targets.add(kStripLanes, weight, pixel);
  SurfacePack& pack = group.pack;
  const auto set = [lane](Lanes& lanes, const StripLanes& values) { StripLanes::Map(lanes.data() + lane) = values; };
  const auto set_all = [lane](Lanes& lanes, float value) { StripLanes::Map(lanes.data() + lane).setConstant(value); };
  set(pack.position.x, strip.position.x);
  set(pack.position.y, strip.position.y);
  set(pack.position.z, strip.position.z);
  set_all(pack.normal.x, point.local.normal.x());
  set_all(pack.normal.y, point.local.normal.y());
  set_all(pack.normal.z, point.local.normal.z());
  set(pack.u, strip.u);
  set(pack.v, strip.v);
  set_all(pack.footprint_m, point.footprint_m);
  set_all(pack.scene_normal.x, point.normal.x());
  set_all(pack.scene_normal.y, point.normal.y());
  set_all(pack.scene_normal.z, point.normal.z());
  set(pack.ray.x, strip.ray.x);
  set(pack.ray.y, strip.ray.y);
  set(pack.ray.z, strip.ray.z);
  set_all(pack.in_sun, point.in_sun);
  if (group.targets.full()) {
    shade(group);
  }
}

void ShadingQueue::add_sky(const Eigen::Vector3f& direction, float weight, float& pixel) {
  sky_directions_.set(sky_targets_.add(1, weight, pixel), direction);
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
