// Rays in a packet hit the same surfaces as single rays.
#include "rendering/ray_world.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "scenes/scenes.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

class Rays : public ::testing::Test {
 protected:
  // Rays from the camera's place into its view, in which actors stand.
  static std::vector<Eigen::Vector3f> directions(std::size_t count) {
    Random random(4, 1);
    std::vector<Eigen::Vector3f> result;
    for (std::size_t i = 0; i < count; ++i) {
      result.emplace_back(static_cast<float>(random.uniform(-0.6, 0.6)), static_cast<float>(random.uniform(-0.2, 0.3)),
                          1.F);
    }
    return result;
  }

  RayPacket traced(std::span<const Eigen::Vector3f> directions) const {
    RayPacket packet;
    packet.count = directions.size();
    for (std::size_t i = 0; i < directions.size(); ++i) {
      packet.set_origin(i, view_);
      packet.set_direction(i, directions[i]);
    }
    world_.trace(packet);
    return packet;
  }

  bool sun_is_hidden(const Eigen::Vector3f& point) const {
    for (std::size_t part = 0; part < world_.parts().size(); ++part) {
      if (world_.meets_part(part, point, scene_.light.to_sun.normalized())) {
        return true;
      }
    }
    return false;
  }

  Scene scene_ = make_scene("street", 1).value();
  RayWorld world_{scene_};
  Eigen::Vector3f view_ = scene_.T_scene_cam(0.0).translation.cast<float>();
};

TEST_F(Rays, MeetTheSameInAPacketAsAlone) {
  const std::vector<Eigen::Vector3f> all = directions(40 * RayPacket::kSize);
  std::size_t on_actors = 0;
  for (std::size_t first = 0; first < all.size(); first += RayPacket::kSize) {
    const std::span<const Eigen::Vector3f> some = std::span(all).subspan(first, RayPacket::kSize);
    const RayPacket together = traced(some);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const RayPacket alone = traced(some.subspan(i, 1));
      ASSERT_EQ(together.part[i], alone.part[0]) << first + i;
      ASSERT_EQ(together.triangle[i], alone.triangle[0]) << first + i;
      if (alone.part[0] != RayPacket::kMiss) {
        ASSERT_EQ(together.distance[i], alone.distance[0]) << first + i;
        on_actors += alone.part[0] > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(on_actors, 20U);
}

// Packets may skip parts; here every part is tested.
TEST_F(Rays, ToTheSunMeetTheSameInAPacketAsAlone) {
  Random random(5, 1);
  std::size_t hidden_by_actors = 0;
  for (double time_s = 0.0; time_s < 5.0; time_s += 1.0) {
    world_.set_time(time_s);
    for (const Actor& actor : scene_.actors) {
      const Eigen::Vector3f middle = actor.T_scene_obj(time_s).translation.cast<float>();
      RayPacket packet;
      packet.count = RayPacket::kSize - 3;
      std::vector<Eigen::Vector3f> points;
      for (std::size_t i = 0; i < packet.count; ++i) {
        points.push_back(middle + Eigen::Vector3f(static_cast<float>(random.uniform(-5.0, 5.0)), -0.3F,
                                                  static_cast<float>(random.uniform(-5.0, 5.0))));
        packet.set_origin(i, points.back());
      }
      world_.trace_shadow(packet);
      for (std::size_t i = 0; i < packet.count; ++i) {
        ASSERT_EQ(packet.blocked[i], sun_is_hidden(points[i])) << points[i].transpose() << " at " << time_s;
        hidden_by_actors +=
            packet.blocked[i] && !world_.meets_part(0, points[i], scene_.light.to_sun.normalized()) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hidden_by_actors, 100U);
}

TEST_F(Rays, OfAnEmptyPacketMeetNothing) {
  RayPacket packet;
  world_.trace(packet);
  world_.trace_shadow(packet);
  EXPECT_EQ(packet.count, 0U);
}

}  // namespace
}  // namespace kinetrace::simulator
