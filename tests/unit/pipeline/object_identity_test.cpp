// Whether an observation belongs to the object: abandoned paths, identity switches of tracks, returns.
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "object_state_fixture.hpp"

namespace kinetrace::pipeline {
namespace {

TEST_F(ObjectStateTest, APathThatIsGivenUpIsReplacedThoughAReconstructionBeginsAtOnce) {
  const auto see = [&](double x_m, std::size_t count) {
    std::vector<Feature> features = front({x_m, 0.2, 12.0});
    features.resize(count);
    observe(object_, track(box_of(features)), features);
  };
  object_.begin(track({}));
  for (int frame = 0; frame < 8; ++frame) {
    see(-2.0, 2);
  }
  EXPECT_EQ(object_.frame_change(), FrameChange::kNone);
  see(2.0, 2);
  see(2.0, 2);
  see(2.0, 20);
  EXPECT_EQ(object_.frame_change(), FrameChange::kReplaced);
}

// While it is hidden, its predicted mask lies on its occluder.
TEST_F(ObjectStateTest, StaysOnItsPathWhereOnlyAPredictedMaskLiesElsewhere) {
  const std::vector<Feature> own = front({-1.5, 0.2, 12.0});
  object_.begin(track(box_of(own)));
  for (int frame = 0; frame < 9; ++frame) {
    observe(object_, track(box_of(own)), own);
  }
  std::vector<Feature> occluder = of_another(front({-1.0, 0.13, 8.0}));
  occluder.resize(4);
  Track predicted = track(box_of(own), 1);
  predicted.box_px = box_of(own);
  predicted.area_px = predicted.box_px.width() * predicted.box_px.height();
  for (int missed = 1; missed <= 6; ++missed) {
    predicted.missed_frames = missed;
    observe(object_, predicted, occluder);
    EXPECT_EQ(object_.frame_change(), FrameChange::kNone) << missed;
  }
  ObjectResult last;
  object_.report(last);
  EXPECT_NEAR(last.T_world_obj.translation.z(), 12.0, 1.0);
}

// Of an occluded object, a mask may have two features, both of what is in front of it.
TEST_F(ObjectStateTest, StaysOnItsPathWhereAnOccludersFeaturesAreOnItsMask) {
  for (const float visible_part : {1.F, 0.4F}) {
    const std::vector<Feature> own = front({-1.5, 0.2, 12.0});
    object_.begin(track(box_of(own)));
    for (int frame = 0; frame < 9; ++frame) {
      observe(object_, track(box_of(own)), own);
    }
    std::vector<Feature> occluder = of_another(front({-0.5, 0.13, 4.0}));
    occluder.resize(2);
    Track seen = track(box_of(own));
    seen.visible_part = visible_part;
    bool is_elsewhere = false;
    for (int frame = 0; frame < 4; ++frame) {
      observe(object_, seen, occluder);
      is_elsewhere = is_elsewhere || object_.frame_change() == FrameChange::kReplaced;
    }
    EXPECT_EQ(is_elsewhere, visible_part == 1.F) << visible_part;
  }
}

// Detected again at the edge of an occluder, with two of the occluder's features on its mask.
TEST_F(ObjectStateTest, KeepsItsIdentityWhereTheFewFeaturesOnItMayBeAnOccluders) {
  const std::vector<Feature> own = front({-1.5, 0.2, 12.0});
  object_.begin(track(box_of(own)));
  for (int frame = 0; frame < 9; ++frame) {
    observe(object_, track(box_of(own)), own);
  }
  for (int missed = 1; missed <= 4; ++missed) {
    observe(object_, track(box_of(own), missed));
  }
  std::vector<Feature> other = of_another(front({-1.5, 0.2, 5.0}));
  other.resize(2);
  observe(object_, track(box_of(own)), other);
  EXPECT_FALSE(object_.identity_switched());
  observe(object_, track(box_of(own)), of_another(front({-1.5, 0.2, 5.0})));
  EXPECT_TRUE(object_.identity_switched()) << "it is still provisional";
}

TEST_F(ObjectStateTest, KeepsItsPosesApartInTimeWhenItsTrackPassesToSomethingElse) {
  constexpr double kAcross_mps = 6.0;
  const auto at = [&](int frame) { return front({-3.0 + 0.1 * kAcross_mps * frame, 0.2, 12.0}); };
  constexpr int kTracked = 9;
  std::vector<Feature> features = at(0);
  object_.begin(track(box_of(features)));
  ObjectResult last;
  for (int frame = 0; frame < kTracked; ++frame) {
    features = at(frame);
    observe(object_, track(box_of(features)), features);
  }
  object_.report(last);
  ASSERT_EQ(last.status, BodyStatus::kTracked);
  constexpr int kMissed = 4;
  for (int missed = 1; missed <= kMissed; ++missed) {
    observe(object_, track(box_of(features), missed));
  }
  const std::vector<Feature> other = of_another(front({-1.5, 0.2, 5.0}));
  observe(object_, track(box_of(other)), other);
  ASSERT_TRUE(object_.identity_switched());
  object_.set_dormant(track({}, kMissed + 1));
  const Eigen::Vector3d reported_m = last.T_obj_cam.translation;
  object_.revise(kMissed + 1, camera_, last);
  EXPECT_LT((last.T_obj_cam.translation - reported_m).norm(), 0.1) << "a frame is " << 0.1 * kAcross_mps << " m";
}

// Its mask reached beyond its edge, and its reconstruction began with the background behind it.
TEST_F(ObjectStateTest, IsWhatIsSeenWithinReachOfItsPredictedBody) {
  const Eigen::Vector3d center_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(center_m);
  object_.begin(track(box_of(features)));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(features)), features);
  }
  for (int missed = 1; missed <= 5; ++missed) {
    observe(object_, track({}, missed));
  }
  const auto evidence = [&](double beside_m) {
    return object_.position_evidence(stereo_at(center_m + Eigen::Vector3d(beside_m, 0.0, 0.0)), redetected({}), camera_)
        .value();
  };
  EXPECT_GT(evidence(0.0), 3.0) << "far likelier than a new object";
  EXPECT_NEAR(evidence(0.3), evidence(0.0), 1.0) << "both are on it";
  EXPECT_LT(evidence(8.0), 0.0);
}

TEST_F(ObjectStateTest, IsNotWhatWasSeenBesideIt) {
  const Eigen::Vector3d center_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(center_m);
  const PixelBox box = box_of(features);
  object_.begin(track(box));
  other_.begin(track(box));
  observe(object_, track(box), features);
  observe(other_, track(box));
  for (int missed = 1; missed <= 5; ++missed) {
    observe(object_, track(box, missed));
    observe(other_, track(box, missed));
  }
  Track newer = redetected(box);
  newer.age_frames = 4;
  EXPECT_TRUE(object_.position_evidence(stereo_at(center_m), newer, camera_));
  EXPECT_TRUE(other_.bearing_evidence(newer, camera_));
  newer.age_frames = 5;
  EXPECT_FALSE(object_.position_evidence(stereo_at(center_m), newer, camera_)) << "first seen when this one was last";
  EXPECT_FALSE(other_.bearing_evidence(newer, camera_));
}

// Motion segmentation finds a part of it again, before a network does.
TEST_F(ObjectStateTest, MayBeWhatIsSeenOfAnUnknownClass) {
  const Eigen::Vector3d center_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(center_m);
  object_.begin(track(box_of(features)));
  observe(object_, track(box_of(features)), features);
  observe(object_, track({}, 1));
  EXPECT_TRUE(object_.position_evidence(stereo_at(center_m), redetected({}, kUnknownClass), camera_));
  EXPECT_FALSE(object_.position_evidence(stereo_at(center_m), redetected({}, kPedestrianClass), camera_));
}

TEST_F(ObjectStateTest, HandsItsNameAndItsBoxOver) {
  const Eigen::Vector3d center_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(center_m);
  object_.begin(track(box_of(features)));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(features)), features);
  }
  ASSERT_EQ(object_.status(), BodyStatus::kTracked);
  ObjectResult before;
  object_.report(before);
  object_.describe_motion(0, before);
  ASSERT_GT(before.box.size_m.x(), 1.0);

  Track redetected = track(box_of(features), 0, 2);
  other_.begin(redetected);
  other_.continue_from(object_);
  EXPECT_EQ(other_.track().id, 1U);
  EXPECT_TRUE(other_.has_position());
  ObjectResult after;
  other_.report(after);
  other_.describe_motion(0, after);
  EXPECT_EQ(after.box.size_m, before.box.size_m);
}

// A mask of another part of a vehicle that drives past begins a new track, which is re-identified at once.
TEST_F(ObjectStateTest, MovesOnWhereItIsReidentified) {
  const Eigen::Vector3d velocity_mps(0.0, 0.0, -4.0);
  const Seen seen = moves_at_the_border(object_, (Vector6d() << Eigen::Vector3d::Zero(), velocity_mps).finished(), 12);
  const PixelBox part = box_of(seen.features);
  other_.begin(redetected(part));
  other_.continue_from(object_);
  observe(other_, redetected(part));
  ObjectResult after;
  other_.report(after);
  other_.describe_motion(0, after);
  EXPECT_NE(after.status, BodyStatus::kTracked);
  EXPECT_TRUE(after.moving);
  EXPECT_NEAR(after.velocity_mps.z(), velocity_mps.z(), 0.5);
}

}  // namespace
}  // namespace kinetrace::pipeline
