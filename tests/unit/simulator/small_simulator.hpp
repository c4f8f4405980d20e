// Small, noise-free simulations: quick, and exact enough to compare pictures with truth.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "rendering/stereo_simulator.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::simulator {

inline SimulatorSettings clean_settings() {
  SimulatorSettings settings;
  settings.sensor = {.noise_levels = 0.0, .vignetting = 0.0, .blur_px = 0.0, .right_gain = 1.0};
  return settings;
}

inline StereoSimulator small_simulator(std::string_view scene_name,
                                       const SimulatorSettings& settings = clean_settings(), int width_px = 414,
                                       std::uint32_t world = 1) {
  Scene scene = make_scene(scene_name, world).value();
  scene.rig = resized(scene.rig, width_px, std::nullopt);
  return StereoSimulator::create(std::move(scene), settings).value();
}

}  // namespace kinetrace::simulator
