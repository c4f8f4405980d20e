// Input of the simulation: a world, actors, light, a stereo rig on a path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "world/mesh.hpp"

namespace kinetrace::simulator {

/// Things that are neither vehicles nor people; KITTI's "Misc".
inline constexpr std::uint16_t kThingClass = 3;

using Trajectory = std::function<Se3(double time_s)>;

/// An object with its own truth. Object frame: x forward, y down, z left, origin under its middle on the ground.
struct Actor {
  std::uint16_t class_id = kVehicleClass;
  bool rigid = true;
  Eigen::Vector3d size_lhw_m = Eigen::Vector3d::Zero();  ///< Of its box: along x, y and z.
  std::vector<Mesh> parts;
  std::shared_ptr<const BodyShape> shape;  ///< Referenced by the parts' paint; null if the actor does not own it.
  Trajectory T_scene_obj;
  /// Pose of a part in the object; empty for rigid objects, whose parts are fixed.
  std::function<Se3(double time_s, std::size_t part)> T_obj_part;
};

struct Light {
  Eigen::Vector3f to_sun = Eigen::Vector3f(-0.45F, -0.75F, -0.35F);  ///< Need not have unit length.
  float sun = 1.F;        ///< Irradiance of a surface facing the sun; a white surface in full light appears as 1.
  float ambient = 0.38F;  ///< From the sky and the surroundings.
  float sky = 1.1F;       ///< Brightness of the sky near the horizon.
  float exposure = 1.F;   ///< Factor from radiance to the sensor's range.
};

/// The scene frame has its origin on the ground, x right, y down, z forward at the start.
struct Scene {
  std::string name;
  Mesh world;
  std::vector<Actor> actors;
  Trajectory T_scene_cam;  ///< Left camera of the rectified rig.
  Light light;
  /// Origin of the world's textures; whole metres.
  Eigen::Vector3f texture_origin_m = Eigen::Vector3f::Zero();
  StereoGeometry rig;
  double rate_hz = 10.0;
  int frames = 100;  ///< The number that the scene was designed for.
};

}  // namespace kinetrace::simulator
