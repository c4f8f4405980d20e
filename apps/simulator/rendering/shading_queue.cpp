#include "rendering/shading_queue.hpp"

#include "kinetrace/core/cpu.hpp"

namespace kinetrace::simulator {
namespace {

Daylight daylight_of(const Light& light) {
  const Eigen::Vector3f to_sun = light.to_sun.normalized();
  return {{to_sun.x(), to_sun.y(), to_sun.z()}, light.sun, light.ambient, light.sky};
}

}  // namespace

const ShadingKernel& shading_kernel() {
  return cpu_runs_fast_kernels() ? kernel_fast::shading_kernel : kernel_baseline::shading_kernel;
}

ShadingQueue::ShadingQueue(const Light& light) : kernel_(shading_kernel()), light_(daylight_of(light)) {}

void ShadingQueue::Targets::receive(const Lanes& radiance) {
  for (std::size_t i = 0; i < count; ++i) {
    *pixels[i] += weights[i] * radiance[i];
  }
  count = 0;
}

// Index of the group, which is created if missing.
std::size_t ShadingQueue::place_of(const Paint& paint, bool strips) {
  std::size_t place = 0;
  while (place < used_ && !groups_[place].has(paint, strips)) {
    ++place;
  }
  if (place == used_) {
    if (++used_ > groups_.size()) {
      groups_.emplace_back();
    }
    groups_[place].paint = paint;
    groups_[place].strips = strips;
  }
  return place;
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
  kernel_.shade(group.paint, group.pack, light_, radiance);
  group.targets.receive(radiance);
}

void ShadingQueue::shade_sky() {
  Lanes radiance;
  kernel_.shade_sky(sky_directions_, light_, radiance);
  sky_targets_.receive(radiance);
}

}  // namespace kinetrace::simulator
