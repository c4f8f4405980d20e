#include "scenes.hpp"

#include <array>
#include <string>

namespace kinetrace::simulator {
namespace {

constexpr std::array<SceneEntry, 1> kScenes{{
    {"street", "a drive through traffic: oncoming, turning, overtaking and parked vehicles, people", &street_scene},
}};

}  // namespace

std::span<const SceneEntry> scenes() {
  return kScenes;
}

Result<Scene> make_scene(std::string_view name) {
  std::string known;
  for (const SceneEntry& entry : kScenes) {
    if (name == entry.name) {
      Scene scene = entry.make();
      scene.name = entry.name;
      return scene;
    }
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  return fail(ErrorCode::kInvalidArgument, "no scene '" + std::string(name) + "'; there are " + known);
}

}  // namespace kinetrace::simulator
