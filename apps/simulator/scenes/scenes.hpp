// The available scenes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "scenes/variation.hpp"
#include "world/scene.hpp"

namespace kinetrace::simulator {

struct SceneEntry {
  const char* name;
  const char* summary;  ///< Its content, in a few words.
  Scene (*make)(const Variation&);
};

[[nodiscard]] std::span<const SceneEntry> scenes();
/// A scene in the given world; see Variation. Errors: kInvalidArgument (no such scene; the message lists all).
[[nodiscard]] Result<Scene> make_scene(std::string_view name, std::uint32_t world = 1);

[[nodiscard]] Scene street_scene(const Variation& variation);
[[nodiscard]] Scene drone_scene(const Variation& variation);
[[nodiscard]] Scene wearable_scene(const Variation& variation);
[[nodiscard]] Scene receding_scene(const Variation& variation);
[[nodiscard]] Scene roundabout_scene(const Variation& variation);
[[nodiscard]] Scene crowd_scene(const Variation& variation);
[[nodiscard]] Scene dark_scene(const Variation& variation);
[[nodiscard]] Scene textureless_scene(const Variation& variation);
[[nodiscard]] Scene pure_rotation_scene(const Variation& variation);
[[nodiscard]] Scene object_fills_image_scene(const Variation& variation);
[[nodiscard]] Scene static_scene(const Variation& variation);
[[nodiscard]] Scene varied_scene(const Variation& variation);

}  // namespace kinetrace::simulator
