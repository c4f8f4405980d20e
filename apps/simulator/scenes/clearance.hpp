// Whether everybody in a scene keeps clear of everybody else.
#pragma once

#include "world/scene.hpp"

namespace kinetrace::simulator {

/// True if at any frame two actors, or an actor and the camera, come closer than people and drivers would let them.
[[nodiscard]] bool somebody_meets(const Scene& scene);

}  // namespace kinetrace::simulator
