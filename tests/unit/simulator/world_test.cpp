// Whether the worlds of a scene are such as there could be: nothing inside anything else, everything on the ground.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "ground_index.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::simulator {
namespace {

constexpr double kStep_s = 0.1;

class World : public ::testing::TestWithParam<std::tuple<const char*, std::uint32_t>> {
 protected:
  double duration_s() const { return (scene_.frames - 1) / scene_.rate_hz; }
  std::string described(std::size_t triangle) const {
    const Mesh::Triangle& met = scene_.world.triangles[triangle];
    const Eigen::Vector3f at = scene_.world.vertices[met.corners[0]].position;
    return "material " + std::to_string(static_cast<int>(met.paint.material)) + " at (" + std::to_string(at.x()) +
           ", " + std::to_string(at.y()) + ", " + std::to_string(at.z()) + ")";
  }

  Scene scene_ = make_scene(std::get<0>(GetParam()), std::get<1>(GetParam())).value();
  GroundIndex ground_{scene_.world};
};

// The box of an actor, a little smaller than it is, without the lowest `clearance_m`.
SolidBox body_of(const Actor& actor, double time_s, double clearance_m) {
  constexpr double kSlack_m = 0.01;
  const double half_height_m = 0.5 * (actor.size_lhw_m.y() - clearance_m);
  const Se3 T_obj_box{Eigen::Matrix3d::Identity(), {0.0, -clearance_m - half_height_m, 0.0}};
  return {actor.T_scene_obj(time_s) * T_obj_box,
          {0.5 * actor.size_lhw_m.x() - kSlack_m, half_height_m, 0.5 * actor.size_lhw_m.z() - kSlack_m}};
}

TEST_P(World, NothingStandsWhereVehiclesAndPeopleAre) {
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const Actor& actor = scene_.actors[i];
    // A curb does not stop somebody who walks.
    const double clearance_m = actor.rigid ? 0.03 : 0.2;
    for (double t = 0.0; t <= duration_s(); t += kStep_s) {
      const auto met = ground_.reaches_into(body_of(actor, t, clearance_m));
      ASSERT_FALSE(met) << "actor " << i + 1 << " at " << t << " meets " << described(*met);
    }
  }
}

TEST_P(World, TheCameraPassesThroughNothing) {
  constexpr double kHead_m = 0.15;
  for (double t = 0.0; t <= duration_s(); t += kStep_s) {
    SolidBox rig{scene_.T_scene_cam(t), {kHead_m, kHead_m, kHead_m}};
    rig.half_m.x() += 0.5 * scene_.rig.baseline_m;
    rig.T_scene_box.translation += 0.5 * scene_.rig.baseline_m * rig.T_scene_box.rotation.col(0);
    const auto met = ground_.reaches_into(rig);
    ASSERT_FALSE(met) << "the camera at " << t << " meets " << described(*met);
  }
}

TEST_P(World, VehiclesStandOnTheGround) {
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const Actor& actor = scene_.actors[i];
    for (double t = 0.0; actor.rigid && t <= duration_s(); t += kStep_s) {
      const Se3 pose = actor.T_scene_obj(t);
      for (const auto& [x, z] : {std::pair{0.4, 0.5}, {0.4, -0.5}, {-0.4, 0.5}, {-0.4, -0.5}}) {
        const Eigen::Vector3d corner = pose * Eigen::Vector3d(x * actor.size_lhw_m.x(), 0.0, z * actor.size_lhw_m.z());
        ASSERT_NEAR(ground_.height_m(corner.x(), corner.z(), 0.5), -corner.y(), 0.01)
            << "actor " << i + 1 << " at " << t;
      }
    }
  }
}

// Lowest point of a part, in scene.
Eigen::Vector3d lowest_point(const Mesh& mesh, const Se3& T_scene_part) {
  Eigen::Vector3d lowest(0.0, -1e9, 0.0);
  for (const Mesh::Vertex& vertex : mesh.vertices) {
    const Eigen::Vector3d at = T_scene_part * vertex.position.cast<double>();
    lowest = at.y() > lowest.y() ? at : lowest;
  }
  return lowest;
}

TEST_P(World, PeopleTreadOnTheGround) {
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const Actor& actor = scene_.actors[i];
    for (double t = 0.0; !actor.rigid && t <= duration_s(); t += kStep_s) {
      double clear_m = 1e9;
      for (std::size_t part = 0; part < actor.parts.size(); ++part) {
        const Eigen::Vector3d sole = lowest_point(actor.parts[part], actor.T_scene_obj(t) * actor.T_obj_part(t, part));
        clear_m = std::min(clear_m, -sole.y() - ground_.height_m(sole.x(), sole.z(), 0.5));
      }
      ASSERT_NEAR(clear_m, 0.0, 0.03) << "actor " << i + 1 << " at " << t;
    }
  }
}

std::vector<const char*> scene_names() {
  std::vector<const char*> names;
  for (const SceneEntry& entry : scenes()) {
    names.push_back(entry.name);
  }
  return names;
}

std::string test_name(const ::testing::TestParamInfo<World::ParamType>& parameters) {
  std::string name = std::get<0>(parameters.param);
  std::erase(name, '-');
  return name + "World" + std::to_string(std::get<1>(parameters.param));
}

INSTANTIATE_TEST_SUITE_P(Scenes, World,
                         ::testing::Combine(::testing::ValuesIn(scene_names()), ::testing::Range(1U, 9U)), test_name);

}  // namespace
}  // namespace kinetrace::simulator
