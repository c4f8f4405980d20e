#include "scenes/scenes.hpp"

#include <array>
#include <string>
#include <vector>

#include "kinetrace/core/nearest_name.hpp"
#include "scenes/clearance.hpp"

namespace kinetrace::simulator {
namespace {

constexpr std::array<SceneEntry, 12> kScenes{{
    {"street", "a drive through traffic: oncoming, turning, overtaking and parked vehicles, people", &street_scene},
    {"drone", "from 13 m above, looking down, shaken: crossing vehicles, people, trees in the way", &drone_scene},
    {"wearable", "in a hall, with fast turns of the head: a trolley is pushed past", &wearable_scene},
    {"receding", "one car drawing away from 8 to 80 m", &receding_scene},
    {"crowd", "64 vehicles and people at once", &crowd_scene},
    {"roundabout", "vehicles that look the same pass behind buses, trees and each other", &roundabout_scene},
    {"dark", "a street at night: mostly noise; nothing moves", &dark_scene},
    {"textureless", "bare walls and ground, one bare car", &textureless_scene},
    {"pure-rotation", "the rig turns in place; one car drives by", &pure_rotation_scene},
    {"object-fills-image", "a truck hides nearly everything", &object_fills_image_scene},
    {"static", "nothing moves, not even the rig", &static_scene},
    {"varied", "any street with any vehicles, people and light, seen from anywhere; for training", &varied_scene},
}};

// The most varied world without collisions; the scene as designed has none.
Scene make_world(const SceneEntry& entry, std::uint32_t world) {
  for (const double variation_strength : {1.0, 0.6, 0.3, 0.0}) {
    const Variation variation(world, variation_strength);
    Scene scene = entry.make(variation);
    variation.apply(scene);
    scene.name = entry.name;
    if (variation_strength == 0.0 || world == 1 || !has_collision(scene)) {
      return scene;
    }
  }
  return {};
}

}  // namespace

std::span<const SceneEntry> scenes() {
  return kScenes;
}

Result<Scene> make_scene(std::string_view name, std::uint32_t world) {
  std::string known;
  std::vector<std::string_view> names;
  for (const SceneEntry& entry : kScenes) {
    if (name == entry.name) {
      return make_world(entry, world);
    }
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
    names.emplace_back(entry.name);
  }
  return fail(ErrorCode::kInvalidArgument,
              "no scene '" + std::string(name) + "'; there are " + known + did_you_mean(name, names));
}

}  // namespace kinetrace::simulator
