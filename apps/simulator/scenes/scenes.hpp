// The scenes one can simulate.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "scene.hpp"

namespace kinetrace::simulator {

struct SceneEntry {
  const char* name;
  const char* summary;  ///< What it shows, in a few words.
  Scene (*make)();
};

[[nodiscard]] std::span<const SceneEntry> scenes();
/// Errors: kInvalidArgument (no such scene; lists those there are).
[[nodiscard]] Result<Scene> make_scene(std::string_view name);

[[nodiscard]] Scene street_scene();
[[nodiscard]] Scene drone_scene();
[[nodiscard]] Scene wearable_scene();
[[nodiscard]] Scene receding_scene();
[[nodiscard]] Scene crowd_scene();
[[nodiscard]] Scene dark_scene();
[[nodiscard]] Scene textureless_scene();
[[nodiscard]] Scene pure_rotation_scene();
[[nodiscard]] Scene object_fills_image_scene();
[[nodiscard]] Scene static_scene();

}  // namespace kinetrace::simulator
