// Determinism, settings, and promises of each scene.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include <gtest/gtest.h>

#include "small_simulator.hpp"

namespace kinetrace::simulator {
namespace {

constexpr int kTiny_px = 250;

bool same_frame(const SimulatedFrame& a, const SimulatedFrame& b) {
  for (std::size_t side = 0; side < 2; ++side) {
    if (a.pictures[side].pixels() != b.pictures[side].pixels() ||
        a.instances[side].pixels() != b.instances[side].pixels() ||
        a.depth_m[side].pixels() != b.depth_m[side].pixels()) {
      return false;
    }
  }
  return true;
}

TEST(StereoSimulator, IsBitIdenticalWhateverTheThreadsAndTheOrder) {
  SimulatorSettings settings;
  settings.threads = 1;
  StereoSimulator alone = small_simulator("street", settings, kTiny_px);
  settings.threads = 3;
  StereoSimulator together = small_simulator("street", settings, kTiny_px);
  const SimulatedFrame third = alone.frame(3);
  (void)alone.frame(0);
  EXPECT_TRUE(same_frame(alone.frame(3), third));
  EXPECT_TRUE(same_frame(together.frame(3), third));
}

TEST(StereoSimulator, IsBitIdenticalInAnotherWorldToo) {
  const auto third_frame = [](int threads) {
    SimulatorSettings settings;
    settings.threads = threads;
    settings.seed = 2;
    Scene scene = make_scene("street", settings.seed).value();
    scene.rig = resized(scene.rig, kTiny_px, std::nullopt);
    return StereoSimulator::create(std::move(scene), settings).value().frame(3);
  };
  EXPECT_TRUE(same_frame(third_frame(1), third_frame(3)));
}

TEST(StereoSimulator, TheSeedChangesTheNoiseAndNothingElse) {
  SimulatorSettings settings;
  StereoSimulator first = small_simulator("street", settings, kTiny_px);
  settings.seed = 2;
  StereoSimulator second = small_simulator("street", settings, kTiny_px);
  const SimulatedFrame a = first.frame(1);
  const SimulatedFrame b = second.frame(1);
  EXPECT_NE(a.pictures[0].pixels(), b.pictures[0].pixels());
  EXPECT_EQ(a.instances[0].pixels(), b.instances[0].pixels());
  EXPECT_EQ(a.depth_m[1].pixels(), b.depth_m[1].pixels());
}

TEST(StereoSimulator, TheWorldIsTheFirstCamera) {
  StereoSimulator simulator = small_simulator("drone", {}, kTiny_px);
  const Se3 first = simulator.frame(0).T_world_cam;
  EXPECT_TRUE(first.rotation.isIdentity(1e-12));
  EXPECT_LT(first.translation.norm(), 1e-12);
  EXPECT_EQ(simulator.frame(0).timestamp_ns % 1'000'000'000, 0);
  EXPECT_EQ(simulator.frame(3).timestamp_ns - simulator.frame(0).timestamp_ns, 150'000'000);
}

TEST(StereoSimulator, AnOpenShutterBlursWhatMoves) {
  SimulatorSettings settings = clean_settings();
  StereoSimulator sharp = small_simulator("wearable", settings, 320);
  settings.shutter_ms = 30.0;
  StereoSimulator blurred = small_simulator("wearable", settings, 320);
  constexpr int kDuringATurn = 35;
  const auto roughness = [](const Image<std::uint8_t>& image) {
    double sum = 0.0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 1; x < image.width(); ++x) {
        sum += std::abs(image.at(x, y) - image.at(x - 1, y));
      }
    }
    return sum;
  };
  EXPECT_LT(roughness(blurred.frame(kDuringATurn).pictures[0]), 0.8 * roughness(sharp.frame(kDuringATurn).pictures[0]));
}

TEST(StereoSimulator, DriftTurnsTheRightCameraOnly) {
  SimulatorSettings settings = clean_settings();
  StereoSimulator steady = small_simulator("street", settings, kTiny_px);
  settings.errors.drift_mrad = 3.0;
  StereoSimulator drifting = small_simulator("street", settings, kTiny_px);
  const SimulatedFrame a = steady.frame(20);
  const SimulatedFrame b = drifting.frame(20);
  EXPECT_EQ(a.pictures[0].pixels(), b.pictures[0].pixels());
  EXPECT_NE(a.pictures[1].pixels(), b.pictures[1].pixels());
  // The truth is that of the calibrated rig. Fused multiplications may round its last digit differently.
  const auto& steady_m = a.depth_m[1].pixels();
  const auto& drifting_m = b.depth_m[1].pixels();
  ASSERT_EQ(steady_m.size(), drifting_m.size());
  std::size_t off = 0;
  for (std::size_t i = 0; i < steady_m.size(); ++i) {
    off += std::abs(steady_m[i] - drifting_m[i]) > 1e-4F * steady_m[i] ? 1 : 0;
  }
  EXPECT_LE(off, steady_m.size() / 1000);
}

TEST(StereoSimulator, RefusesSettingsOutOfRange) {
  SimulatorSettings settings;
  settings.samples_per_side = 5;
  EXPECT_FALSE(settings.validate());
  settings = {};
  settings.sensor.noise_levels = std::nan("");
  EXPECT_FALSE(settings.validate());
  settings = {};
  settings.threads = 0;
  const Status status = settings.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("threads"), std::string::npos);
  EXPECT_TRUE(SimulatorSettings{}.validate());
}

struct Levels {
  double mean = 0.0;
  double deviation = 0.0;
};

Levels levels_of(const Image<std::uint8_t>& image) {
  double sum = 0.0;
  double squares = 0.0;
  for (const std::uint8_t level : image.pixels()) {
    sum += level;
    squares += level * level;
  }
  const auto n = static_cast<double>(image.pixels().size());
  return {sum / n, std::sqrt(squares / n - sum / n * sum / n)};
}

TEST(Scenes, AreExposedLikePhotographs) {
  for (const char* name : {"street", "drone", "wearable", "receding", "crowd", "pure-rotation", "static"}) {
    StereoSimulator simulator = small_simulator(name, {}, kTiny_px);
    const Levels levels = levels_of(simulator.frame(5).pictures[0]);
    EXPECT_GT(levels.mean, 80.0) << name;
    EXPECT_LT(levels.mean, 150.0) << name;
    EXPECT_GT(levels.deviation, 25.0) << name;
    EXPECT_LT(levels.deviation, 75.0) << name;
  }
}

TEST(Scenes, StreetShowsMovingVehiclesNearbyThroughout) {
  StereoSimulator simulator = small_simulator("street", {}, kTiny_px);
  ASSERT_GE(simulator.scene().frames, 60);
  std::set<int> seen;
  for (int i = 0; i < simulator.scene().frames; i += 9) {
    int near = 0;
    const SimulatedFrame frame = simulator.frame(i);
    for (const ObjectTruth& object : frame.objects) {
      const double distance_m = (frame.T_world_cam.inverse() * object.T_world_obj.translation).norm();
      if (object.moving && object.rigid && object.visible_px > 0 && distance_m < 30.0) {
        ++near;
        seen.insert(object.id);
      }
    }
    EXPECT_GE(near, 1) << "frame " << i;
  }
  EXPECT_GE(seen.size(), 6U);
}

TEST(Scenes, CrowdHoldsAsManyObjectsAsThereCanBe) {
  StereoSimulator simulator = small_simulator("crowd", {}, 414);
  const SimulatedFrame frame = simulator.frame(0);
  EXPECT_EQ(frame.objects.size(), 64U);
  EXPECT_GE(std::count_if(frame.objects.begin(), frame.objects.end(),
                          [](const ObjectTruth& object) { return object.visible_px > 0; }),
            55);
}

TEST(Scenes, RecedingGoesFromEightToEightyMetres) {
  StereoSimulator simulator = small_simulator("receding", {}, kTiny_px);
  const auto gap_m = [&](int index) {
    const SimulatedFrame frame = simulator.frame(index);
    return (frame.T_world_cam.inverse() * frame.objects.front().T_world_obj.translation).z() -
           0.5 * frame.objects.front().size_lhw_m.x();
  };
  EXPECT_NEAR(gap_m(0), 8.0, 1.0);
  EXPECT_NEAR(gap_m(simulator.scene().frames - 1), 80.0, 4.0);
}

TEST(Scenes, NothingMovesInStaticAndDark) {
  for (const char* name : {"static", "dark"}) {
    StereoSimulator simulator = small_simulator(name, {}, kTiny_px);
    for (const ObjectTruth& object : simulator.frame(30).objects) {
      EXPECT_FALSE(object.moving) << name;
    }
  }
  StereoSimulator dark = small_simulator("dark", {}, kTiny_px);
  EXPECT_LT(levels_of(dark.frame(0).pictures[0]).mean, 40.0);
  StereoSimulator still = small_simulator("static", {}, kTiny_px);
  EXPECT_LT(still.frame(50).T_world_cam.translation.norm(), 1e-12);
}

TEST(Scenes, PureRotationTurnsWithoutMoving) {
  StereoSimulator simulator = small_simulator("pure-rotation", {}, kTiny_px);
  const Se3 pose = simulator.frame(15).T_world_cam;
  // The left view is the centre of the turn.
  EXPECT_LT(pose.translation.norm(), 1e-9);
  EXPECT_GT(so3_log(pose.rotation).norm(), 0.2);
}

TEST(Scenes, ObjectFillsImageComesToHideNearlyEverything) {
  StereoSimulator simulator = small_simulator("object-fills-image", {}, kTiny_px);
  double largest = 0.0;
  for (int i = 0; i < simulator.scene().frames; i += 4) {
    const SimulatedFrame frame = simulator.frame(i);
    const double pixels = static_cast<double>(frame.instances[0].pixels().size());
    for (const ObjectTruth& object : frame.objects) {
      largest = std::max(largest, object.moving ? object.visible_px / pixels : 0.0);
    }
  }
  EXPECT_GT(largest, 0.7);
}

}  // namespace
}  // namespace kinetrace::simulator
