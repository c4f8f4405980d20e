// Boxes of rendered vehicles, with masks degraded like a network's, against the truth.
#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "kinetrace/evaluation/box_metrics.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "simulated_sequence.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using evaluation::LocatedObject;

constexpr int kMinHeight_px = 30;
constexpr int kGrownFrames = 10;
constexpr double kSame_m = 3.0;

/// The true object nearest to a box, if within kSame_m.
const LocatedObject* object_at(const std::vector<LocatedObject>& objects, const Eigen::Vector3d& center_m) {
  const auto distance_m = [&](const LocatedObject& one) { return (one.center_m - center_m).norm(); };
  const auto nearest =
      std::min_element(objects.begin(), objects.end(),
                       [&](const LocatedObject& a, const LocatedObject& b) { return distance_m(a) < distance_m(b); });
  return nearest != objects.end() && distance_m(*nearest) < kSame_m ? &*nearest : nullptr;
}

void add_errors(const Followed& followed, const evaluation::Truth& truth, double range_m,
                evaluation::BoxErrors& errors) {
  std::map<std::uint32_t, int> frames_of;
  for (std::size_t i = 0; i < followed.finalised.size(); ++i) {
    const FollowedFrame& frame = followed.finalised[i];
    for (const ObjectResult& object : frame.objects) {
      const LocatedObject* found = object_at(truth.objects.at(static_cast<std::int64_t>(i)), object.box.center_m);
      if (found == nullptr || !found->object.rigid || found->object.height_px < kMinHeight_px ||
          found->object.hidden > 0.3 || ++frames_of[object.track_id] <= kGrownFrames ||
          (found->center_m - frame.T_world_cam_true.translation).norm() > range_m) {
        continue;
      }
      evaluation::compare({{found->object.T_world_obj.rotation, found->center_m}, found->object.size_m}, object.box,
                          object.box_sigma, errors);
    }
  }
}

class Boxes : public ::testing::TestWithParam<const char*> {};

TEST_P(Boxes, HoldTheWholeVehicleAndStandOnTheGround) {
  evaluation::BoxErrors errors;
  for (const std::uint32_t seed : {1U, 2U, 3U}) {  // A single box makes a fifth of one world's mean.
    const TempFolder folder;
    const SimulatedSequence sequence(folder.path() / "scene", GetParam(), 32, 620, {}, seed);
    evaluation::TruthSource source;
    source.path = folder.path() / "scene";
    const auto truth = evaluation::read_truth(source);
    ASSERT_TRUE(truth) << truth.error().message;
    add_errors(sequence.follow(sequence.masked()), *truth, 25.0, errors);
  }
  ASSERT_GT(errors.iou_3d.count(), 20U);
  EXPECT_GT(errors.iou_3d.mean().value(), 0.65);
  EXPECT_LT(errors.center_m.mean().value(), 0.5);  // Pictures of half the size.
  EXPECT_LT(errors.yaw_deg.mean().value(), 8.0);
  EXPECT_EQ(errors.known_turned, 0U);
  EXPECT_LT(errors.center_normalised.mean_square().value(), 4.0);
}

// The drone looks down by 43 degrees: its boxes stand on the ground, not along its y axis.
INSTANTIATE_TEST_SUITE_P(Scenes, Boxes, ::testing::Values("street", "drone"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace kinetrace::test
