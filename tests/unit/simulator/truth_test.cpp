// The truth against the pictures, and against itself.
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "alignment.hpp"
#include "rendering/object_truth.hpp"
#include "small_simulator.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3d;

constexpr int kWideEnough_px = 828;

Side side_of(const SimulatedFrame& frame, std::size_t side) {
  return {frame.pictures[side], frame.depth_m[side]};
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  // Barycentric coordinates of the foot point, or the nearest edge.
  const Vector3d n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0.0) {
    const Vector3d foot = p - n * (n.dot(p - a) / n.squaredNorm());
    const bool within = n.dot((b - a).cross(foot - a)) >= 0 && n.dot((c - b).cross(foot - b)) >= 0 &&
                        n.dot((a - c).cross(foot - c)) >= 0;
    if (within) {
      return (p - foot).norm();
    }
  }
  double nearest = 1e9;
  for (const auto& [s, e] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    const double length_sq = (e - s).squaredNorm();
    const double t = length_sq > 0.0 ? std::clamp((p - s).dot(e - s) / length_sq, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (p - s - t * (e - s)).norm());
  }
  return nearest;
}

double distance_to_mesh(const Vector3d& p, const Mesh& mesh) {
  double nearest = 1e9;
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Vector3d {
      return mesh.vertices[triangle.corners[i]].position.cast<double>();
    };
    nearest = std::min(nearest, distance_to_triangle(p, corner(0), corner(1), corner(2)));
  }
  return nearest;
}

class SceneTruth : public ::testing::TestWithParam<const char*> {};

TEST_P(SceneTruth, PixelsOfAnObjectLieOnItsMeshAtItsPose) {
  StereoSimulator simulator = small_simulator(GetParam());
  const SimulatedFrame frame = simulator.frame(20);
  const StereoGeometry& g = simulator.scene().rig;
  int checked = 0;
  for (const ObjectTruth& object : frame.objects) {
    const Actor& actor = simulator.scene().actors[static_cast<std::size_t>(object.id) - 1];
    if (!object.rigid || object.visible_px < 50) {
      continue;
    }
    Random random(7, object.id);
    for (int i = 0; i < 40; ++i) {
      const int x = object.box_px.x0 + random.index(object.box_px.width());
      const int y = object.box_px.y0 + random.index(object.box_px.height());
      if (frame.instances[0].at(x, y) != object.class_id * 1000 + object.id) {
        continue;
      }
      const double depth_m = static_cast<double>(frame.depth_m[0].at(x, y));
      const Vector3d p_cam = g.triangulate(x, y, g.disparity_px(depth_m));
      const Vector3d p_obj = object.T_world_obj.inverse() * (frame.T_world_cam * p_cam);
      EXPECT_LT(distance_to_mesh(p_obj, actor.parts.front()), 0.002 + 1e-5 * depth_m) << "object " << object.id;
      ++checked;
    }
  }
  EXPECT_GT(checked, 20);
}

TEST_P(SceneTruth, BothCamerasSeeTheSameSurfaceAtTheDisparity) {
  StereoSimulator simulator = small_simulator(GetParam(), clean_settings(), kWideEnough_px);
  const SimulatedFrame frame = simulator.frame(10);
  const StereoGeometry& g = simulator.scene().rig;
  const Alignment fit = align(side_of(frame, 0), side_of(frame, 1), [&](int u, int v, double depth_m) {
    return std::optional(Vector3d(u - g.disparity_px(depth_m), v, depth_m));
  });
  EXPECT_GT(fit.count, 20000);
  EXPECT_GT(fit.expected_share, 0.85);  // The rest is hidden from the right view, or near an edge.
  EXPECT_LT(fit.mean_abs_levels, 4.0);
  EXPECT_NEAR(fit.offset_px.x(), 0.0, 0.02);
  EXPECT_NEAR(fit.offset_px.y(), 0.0, 0.02);
}

TEST_P(SceneTruth, StaticPointsMoveWithTheCameraAlone) {
  StereoSimulator simulator = small_simulator(GetParam(), clean_settings(), kWideEnough_px);
  const SimulatedFrame before = simulator.frame(10);
  const SimulatedFrame after = simulator.frame(11);
  const StereoGeometry& g = simulator.scene().rig;
  const Se3 T_after_before = after.T_world_cam.inverse() * before.T_world_cam;
  const Alignment fit =
      align(side_of(before, 0), side_of(after, 0), [&](int u, int v, double depth_m) -> std::optional<Vector3d> {
        if (before.instances[0].at(u, v) != 0) {
          return std::nullopt;
        }
        const Vector3d p = T_after_before * g.triangulate(u, v, g.disparity_px(depth_m));
        const Vector3d uvr = g.project(p);
        return Vector3d(uvr.x(), uvr.y(), p.z());
      });
  EXPECT_GT(fit.count, 10000);
  EXPECT_GT(fit.expected_share, 0.8);
  EXPECT_LT(fit.mean_abs_levels, 5.0);
  EXPECT_NEAR(fit.offset_px.x(), 0.0, 0.03);
  EXPECT_NEAR(fit.offset_px.y(), 0.0, 0.03);
}

TEST_P(SceneTruth, PointsOfMovingBodiesMoveWithTheirPose) {
  StereoSimulator simulator = small_simulator(GetParam(), clean_settings(), 1242);
  const SimulatedFrame before = simulator.frame(12);
  const SimulatedFrame after = simulator.frame(13);
  const StereoGeometry& g = simulator.scene().rig;
  std::map<int, Se3> T_after_before;  // By MOTS label: camera to camera, riding on the body.
  for (std::size_t i = 0; i < before.objects.size(); ++i) {
    const ObjectTruth& object = before.objects[i];
    if (object.moving && object.rigid) {
      T_after_before[object.class_id * 1000 + object.id] = after.T_world_cam.inverse() * after.objects[i].T_world_obj *
                                                           object.T_world_obj.inverse() * before.T_world_cam;
    }
  }
  const Alignment fit =
      align(side_of(before, 0), side_of(after, 0), [&](int u, int v, double depth_m) -> std::optional<Vector3d> {
        const auto body = T_after_before.find(before.instances[0].at(u, v));
        if (body == T_after_before.end()) {
          return std::nullopt;
        }
        const Vector3d p = body->second * g.triangulate(u, v, g.disparity_px(depth_m));
        const Vector3d uvr = g.project(p);
        return Vector3d(uvr.x(), uvr.y(), p.z());
      });
  EXPECT_GT(fit.count, 1000);
  EXPECT_GT(fit.expected_share, 0.75);
  EXPECT_LT(fit.mean_abs_levels, 6.0);
  // Reflections do not move with the paint, hence a larger tolerance than above.
  EXPECT_NEAR(fit.offset_px.x(), 0.0, 0.06);
  EXPECT_NEAR(fit.offset_px.y(), 0.0, 0.06);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneTruth, ::testing::Values("street", "drone", "wearable"));

TEST(ObjectTruth, CountsExactlyThePixelsOfItsMask) {
  StereoSimulator simulator = small_simulator("street");
  const SimulatedFrame frame = simulator.frame(30);
  std::map<int, int> pixels;
  for (const std::uint16_t label : frame.instances[0].pixels()) {
    ++pixels[label];
  }
  int visible = 0;
  for (const ObjectTruth& object : frame.objects) {
    EXPECT_EQ(object.visible_px, pixels[object.class_id * 1000 + object.id]) << "object " << object.id;
    visible += object.visible_px;
  }
  EXPECT_EQ(frame.objects.size(), simulator.scene().actors.size());
  EXPECT_EQ(visible + pixels[0], frame.instances[0].width() * frame.instances[0].height());
}

TEST(ObjectTruth, MasksLieInTheProjectedBoxes) {
  StereoSimulator simulator = small_simulator("street");
  const SimulatedFrame frame = simulator.frame(45);
  int checked = 0;
  for (const ObjectTruth& object : frame.objects) {
    // Arms and legs of pedestrians swing out of their boxes.
    if (object.rigid && object.visible_px > 0) {
      const auto& [left, top, right, bottom] = object.projected_px;
      const double mirrors_px = 2.0 + 0.06 * (right - left);
      EXPECT_GE(object.box_px.x0, left - mirrors_px) << "object " << object.id;
      EXPECT_LE(object.box_px.x1 - 1, right + mirrors_px) << "object " << object.id;
      EXPECT_GE(object.box_px.y0, top - 1.0) << "object " << object.id;
      EXPECT_LE(object.box_px.y1 - 1, bottom + 1.0) << "object " << object.id;
      ++checked;
    }
  }
  EXPECT_GT(checked, 4);
}

// A board of `size_m` across the view, `z_m` ahead at view height.
void add_board(Scene& scene, double z_m, double x_m, double size_m) {
  Actor& board = scene.actors.emplace_back();
  board.size_lhw_m = {size_m, size_m, 0.02};
  const auto size = static_cast<float>(size_m);
  board.parts.emplace_back().add_box({0.F, -0.5F * size, 0.F}, {size, size, 0.02F}, {Material::kPoster});
  board.T_scene_obj = [=](double) { return Se3{Eigen::Matrix3d::Identity(), {x_m, 0.5 * size_m, z_m}}; };
}

TEST(ObjectTruth, OcclusionIsThePartThatOthersHide) {
  // The near board covers the left half of the far one, which is twice as large and twice as far.
  Scene scene;
  scene.rig = {200.0, 200.0, 99.5, 49.5, 0.2, 200, 100};
  scene.T_scene_cam = [](double) { return Se3{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}; };
  add_board(scene, 10.0, 0.0, 2.0);
  add_board(scene, 5.0, -0.5, 1.0);
  StereoSimulator simulator = StereoSimulator::create(std::move(scene), clean_settings()).value();
  const SimulatedFrame frame = simulator.frame(0);
  EXPECT_NEAR(frame.objects[0].occlusion, 0.5, 0.06);
  EXPECT_DOUBLE_EQ(frame.objects[1].occlusion, 0.0);
  EXPECT_DOUBLE_EQ(frame.objects[0].truncation, 0.0);
  EXPECT_FALSE(frame.objects[0].moving);
}

}  // namespace
}  // namespace kinetrace::simulator
