// Paths, speeds, and physically plausible motion of the scenes' actors.
#include "world/motion.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/scenes.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

double heading_rad(const Se3& pose) {
  return std::atan2(-pose.rotation(2, 0), pose.rotation(0, 0));
}

TEST(GroundPath, RunsStraightFromTheFirstToTheLastPoint) {
  const GroundPath path(Points{{1.0, 2.0}, {1.0, 32.0}});
  EXPECT_NEAR(path.length_m(), 30.0, 1e-9);
  EXPECT_TRUE(path.pose_at(0.0).translation.isApprox(Eigen::Vector3d(1.0, 0.0, 2.0), 1e-12));
  EXPECT_TRUE(path.pose_at(12.5).translation.isApprox(Eigen::Vector3d(1.0, 0.0, 14.5), 1e-9));
  EXPECT_NEAR(heading_rad(path.pose_at(12.5)), -0.5 * std::numbers::pi, 1e-12);
}

TEST(GroundPath, ContinuesStraightBeyondItsEnds) {
  const GroundPath path(Points{{0.0, 0.0}, {10.0, 0.0}});
  EXPECT_NEAR(path.pose_at(-3.0).translation.x(), -3.0, 1e-9);
  EXPECT_NEAR(path.pose_at(17.0).translation.x(), 17.0, 1e-9);
}

TEST(GroundPath, HeadsWhereItGoes) {
  const GroundPath path(Points{{0, 0}, {0, 20}, {4, 28}, {12, 32}, {40, 32}});
  for (double s = 0.5; s < path.length_m(); s += 0.37) {
    const Eigen::Vector3d step = path.pose_at(s + 1e-3).translation - path.pose_at(s - 1e-3).translation;
    EXPECT_NEAR(step.norm(), 2e-3, 4e-6) << s;
    EXPECT_LT((path.pose_at(s).rotation.col(0) - step.normalized()).norm(), 0.01) << s;
  }
}

TEST(SpeedProfile, TravelsAtConstantSpeed) {
  const SpeedProfile speed({{0.0, 7.0}});
  EXPECT_DOUBLE_EQ(speed.distance_m(3.0), 21.0);
  EXPECT_DOUBLE_EQ(speed.distance_m(-1.0), -7.0);
}

TEST(SpeedProfile, IntegratesAChangeOfSpeed) {
  const SpeedProfile speed({{1.0, 4.0}, {3.0, 8.0}});
  // A symmetric step: the mean speed over it is the mean of both ends.
  EXPECT_NEAR(speed.distance_m(3.0), 4.0 + 2.0 * 6.0, 1e-12);
  EXPECT_NEAR(speed.distance_m(5.0), 4.0 + 12.0 + 16.0, 1e-12);
  const double h = 1e-5;
  EXPECT_NEAR((speed.distance_m(2.0 + h) - speed.distance_m(2.0 - h)) / (2 * h), 6.0, 1e-6);
}

TEST(Sway, StaysNearItsAmplitudesAndDependsOnItsSeed) {
  const Sway sway{{0.02, 0.0, 0.0}, {0.0, 0.1, 0.0}, 0.3, 2.0, 1};
  double largest_m = 0.0;
  for (double t = 0.0; t < 20.0; t += 0.05) {
    const Se3 pose = sway_at(sway, t);
    largest_m = std::max(largest_m, std::abs(pose.translation.y()));
    EXPECT_LE(so3_log(pose.rotation).norm(), 0.02 * 2.4);
    EXPECT_EQ(pose.translation.x(), 0.0);
  }
  EXPECT_GT(largest_m, 0.05);
  Sway other = sway;
  other.seed = 2;
  EXPECT_GT((sway_at(sway, 1.0).translation - sway_at(other, 1.0).translation).norm(), 1e-4);
}

// Every scene in several worlds, at every frame.
class SceneMotion : public ::testing::TestWithParam<std::tuple<const char*, std::uint32_t>> {
 protected:
  Scene scene_ = make_scene(std::get<0>(GetParam()), std::get<1>(GetParam())).value();
  double duration_s() const { return (scene_.frames - 1) / scene_.rate_hz; }
};

TEST_P(SceneMotion, VehiclesSteerAndAccelerateLikeVehicles) {
  constexpr double kStep_s = 0.02;
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const Actor& actor = scene_.actors[i];
    if (!actor.rigid) {
      continue;
    }
    for (double t = kStep_s; t < duration_s(); t += 2.0 * kStep_s) {
      const Se3 before = actor.T_scene_obj(t - kStep_s);
      const Se3 now = actor.T_scene_obj(t);
      const Se3 after = actor.T_scene_obj(t + kStep_s);
      const Eigen::Vector3d velocity = (after.translation - before.translation) / (2.0 * kStep_s);
      const Eigen::Vector3d acceleration =
          (after.translation - 2.0 * now.translation + before.translation) / (kStep_s * kStep_s);
      const double yaw_rate = so3_log(before.rotation.transpose() * after.rotation).norm() / (2.0 * kStep_s);
      EXPECT_LT(acceleration.norm(), 6.0) << "actor " << i + 1 << " at " << t;
      EXPECT_LT(yaw_rate, 1.6) << "actor " << i + 1 << " at " << t;
      if (velocity.norm() > 0.1) {
        EXPECT_GT(now.rotation.col(0).dot(velocity.normalized()), 0.999) << "actor " << i + 1 << " at " << t;
      }
    }
  }
}

struct Rectangle {
  Eigen::Vector2d centre, along, across;  // Half extents.
};

Rectangle ground_rectangle(const Actor& actor, double time_s) {
  const Se3 pose = actor.T_scene_obj(time_s);
  const auto flat = [](const Eigen::Vector3d& v) { return Eigen::Vector2d(v.x(), v.z()); };
  return {flat(pose.translation), 0.5 * actor.size_lhw_m.x() * flat(pose.rotation.col(0)),
          0.5 * actor.size_lhw_m.z() * flat(pose.rotation.col(2))};
}

// Separating axes of two rectangles.
bool overlap(const Rectangle& a, const Rectangle& b) {
  for (const Eigen::Vector2d& axis : {a.along, a.across, b.along, b.across}) {
    const Eigen::Vector2d n = axis.normalized();
    const double reach =
        std::abs(n.dot(a.along)) + std::abs(n.dot(a.across)) + std::abs(n.dot(b.along)) + std::abs(n.dot(b.across));
    if (std::abs(n.dot(b.centre - a.centre)) > reach) {
      return false;
    }
  }
  return true;
}

TEST_P(SceneMotion, NothingRunsIntoAnythingElse) {
  for (double t = 0.0; t <= duration_s(); t += 0.1) {
    std::vector<Rectangle> places;
    for (const Actor& actor : scene_.actors) {
      places.push_back(ground_rectangle(actor, t));
    }
    const Eigen::Vector3d view = scene_.T_scene_cam(t).translation;
    const Rectangle camera{{view.x(), view.z()}, {0.3, 0.0}, {0.0, 0.3}};
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = i + 1; j < places.size(); ++j) {
        ASSERT_FALSE(overlap(places[i], places[j])) << "actors " << i + 1 << ", " << j + 1 << " at " << t;
      }
      const bool below = -view.y() > scene_.actors[i].size_lhw_m.y() + 1.0;
      ASSERT_TRUE(below || !overlap(places[i], camera)) << "actor " << i + 1 << " and the camera at " << t;
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

std::string test_name(const ::testing::TestParamInfo<SceneMotion::ParamType>& parameters) {
  std::string name = std::get<0>(parameters.param);
  std::erase(name, '-');
  return name + "World" + std::to_string(std::get<1>(parameters.param));
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneMotion,
                         ::testing::Combine(::testing::ValuesIn(scene_names()), ::testing::Range(1U, 9U)), test_name);

TEST(Scenes, NamesThoseThereAreWhenAskedForAnother) {
  const Result<Scene> scene = make_scene("moon");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(scene.error().message.find("moon"), std::string::npos);
  EXPECT_NE(scene.error().message.find("pure-rotation"), std::string::npos);
  EXPECT_NE(make_scene("strete").error().message.find("did you mean street?"), std::string::npos);
}

}  // namespace
}  // namespace kinetrace::simulator
