// Clearance between the actors and the camera of a scene.
#pragma once

#include "world/scene.hpp"

namespace kinetrace::simulator {

/// True if at any frame two actors, or an actor and the camera, come closer than people and drivers would allow.
[[nodiscard]] bool has_collision(const Scene& scene);

}  // namespace kinetrace::simulator
