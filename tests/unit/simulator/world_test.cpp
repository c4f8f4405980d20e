// The worlds of a scene are plausible: no interpenetration, all objects on the ground.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "ground_index.hpp"
#include "scenes/clearance.hpp"
#include "scenes/scenes.hpp"
#include "world/people.hpp"

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

// The box of an actor, slightly shrunk, without the lowest `clearance_m`.
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
    // A pedestrian can step on a curb.
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

// Lowest point of a part, in the scene's frame.
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

// The vertex on which a pedestrian stands.
struct Contact {
  std::size_t part = 0;
  std::size_t vertex = 0;
};

Eigen::Vector3d point_at(const Actor& actor, const Contact& contact, double time_s) {
  return actor.T_scene_obj(time_s) * actor.T_obj_part(time_s, contact.part) *
         actor.parts[contact.part].vertices[contact.vertex].position.cast<double>();
}

Contact contact_of(const Actor& actor, double time_s) {
  Contact lowest;
  double lowest_y = -1e9;
  for (std::size_t part = 0; part < actor.parts.size(); ++part) {
    for (std::size_t vertex = 0; vertex < actor.parts[part].vertices.size(); ++vertex) {
      if (const double y = point_at(actor, {part, vertex}, time_s).y(); y > lowest_y) {
        lowest_y = y;
        lowest = {part, vertex};
      }
    }
  }
  return lowest;
}

// Except for the moments when a foot lands or rolls off.
TEST_P(World, FeetStayWhereTheyTread) {
  constexpr double kMoment_s = 0.01;
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const Actor& actor = scene_.actors[i];
    std::vector<double> slid;  // Relative to the body's motion.
    for (double t = 0.0; !actor.rigid && t <= 2.0; t += 0.07) {
      const Contact contact = contact_of(actor, t);
      const double slid_m = (point_at(actor, contact, t + kMoment_s) - point_at(actor, contact, t)).norm();
      const double moved_m = (actor.T_scene_obj(t + kMoment_s).translation - actor.T_scene_obj(t).translation).norm();
      // A standing pedestrian moves neither body nor feet.
      slid.push_back(moved_m > 0.0 ? slid_m / moved_m : slid_m);
    }
    if (!slid.empty()) {
      std::nth_element(slid.begin(), slid.begin() + static_cast<std::ptrdiff_t>(slid.size() / 2), slid.end());
      EXPECT_LT(slid[slid.size() / 2], 0.1) << "actor " << i + 1;
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

// Positions and sizes of all actors.
std::vector<Eigen::Vector3d> census(const Scene& scene, double time_s) {
  std::vector<Eigen::Vector3d> result;
  for (const Actor& actor : scene.actors) {
    result.push_back(actor.T_scene_obj(time_s).translation);
    result.push_back(actor.size_lhw_m);
  }
  return result;
}

TEST(Worlds, OfTheSameSeedAreTheSame) {
  for (const std::uint32_t world : {1U, 2U, 9U}) {
    const Scene first = make_scene("street", world).value();
    const Scene second = make_scene("street", world).value();
    EXPECT_EQ(census(first, 3.3), census(second, 3.3));
    ASSERT_EQ(first.world.vertices.size(), second.world.vertices.size());
    EXPECT_TRUE(std::equal(first.world.vertices.begin(), first.world.vertices.end(), second.world.vertices.begin(),
                           [](const Mesh::Vertex& a, const Mesh::Vertex& b) { return a.position == b.position; }));
  }
}

double travelled_m(const Scene& scene, std::size_t actor) {
  const Trajectory& T_scene_obj = scene.actors[actor].T_scene_obj;
  return (T_scene_obj(2.0).translation - T_scene_obj(0.0).translation).norm();
}

TEST(Worlds, DifferInPacePlacesHeightsAndEmptySpots) {
  const Scene laid_out = make_scene("street", 1).value();
  std::set<std::size_t> counts;
  std::set<double> heights_m;
  std::set<double> ratios;
  std::set<double> lanes_m;
  for (std::uint32_t world = 2; world <= 8; ++world) {
    const Scene scene = make_scene("street", world).value();
    counts.insert(scene.actors.size());
    EXPECT_LE(scene.actors.size(), laid_out.actors.size());
    EXPECT_GE(scene.actors.size() + 6, laid_out.actors.size());
    heights_m.insert(scene.actors[7].size_lhw_m.y());
    ratios.insert(travelled_m(scene, 0) / travelled_m(scene, 1));
    lanes_m.insert(scene.actors[0].T_scene_obj(0.0).translation.x());
  }
  EXPECT_GE(counts.size(), 3U);
  EXPECT_GE(heights_m.size(), 5U);
  EXPECT_GE(ratios.size(), 5U);
  EXPECT_GE(lanes_m.size(), 5U);
  EXPECT_GT(*heights_m.begin(), 1.55);
  EXPECT_LT(*heights_m.rbegin(), 1.95);
}

TEST(Worlds, WithoutLibertyEverybodyIsWhereTheSceneHasThem) {
  const Variation bound(5, 0.0);
  EXPECT_EQ(bound.place_m(12.0, 3), 12.0);
  EXPECT_EQ(bound.height_m(3), kPersonHeight_m);
  EXPECT_FALSE(bound.is_empty(3));
  EXPECT_EQ(bound.paced(SpeedProfile({{0.0, 8.0}}), 3).distance_m(2.0), 16.0);
}

TEST(Clearance, FindsOutWhoMeets) {
  Scene scene;
  scene.frames = 30;
  scene.T_scene_cam = parked(0.0, -50.0, 0.0);
  const auto add = [&](double x_m, double speed_mps) {
    Actor& actor = scene.actors.emplace_back();
    actor.size_lhw_m = {4.0, 1.5, 1.8};
    actor.T_scene_obj = drive(GroundPath({{x_m, 0.0}, {x_m + 40.0, 0.0}}), SpeedProfile({{0.0, speed_mps}}), 0.0);
  };
  add(0.0, 5.0);
  EXPECT_FALSE(has_collision(scene));
  add(10.0, 4.0);
  EXPECT_FALSE(has_collision(scene));
  // Catches up within the recording.
  add(-10.0, 8.0);
  EXPECT_TRUE(has_collision(scene));
  scene.actors.pop_back();
  scene.T_scene_cam = parked(12.0, 0.0, 0.0);
  EXPECT_TRUE(has_collision(scene));
}

}  // namespace
}  // namespace kinetrace::simulator
