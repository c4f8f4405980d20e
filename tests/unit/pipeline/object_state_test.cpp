// Position of one object: visible, partly occluded and unseen.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "frame_result_builder.hpp"
#include "object_state_fixture.hpp"

namespace kinetrace::pipeline {
namespace {

TEST_F(ObjectStateTest, WaitsInItsDirectionWhileItHasNoPlace) {
  const PixelBox box{60, 40, 68, 46};
  object_.begin(track(box));
  observe(object_, track(box));
  const tracking::ObjectPrediction prediction = object_.prediction(time_ns_, camera_.T_world_cam);
  EXPECT_TRUE(prediction.known && prediction.direction_only);
  EXPECT_LT((prediction.point_px - Eigen::Vector2d(63.5, 42.5)).norm(), 1e-6);
  EXPECT_FALSE(object_.bearing_evidence(redetected(box), camera_)) << "detected itself";

  observe(object_, track(box, 1));
  const auto evidence = [&](const PixelBox& seen) {
    return object_.bearing_evidence(redetected(seen), camera_).value();
  };
  EXPECT_GT(evidence(box), 3.0);
  EXPECT_FALSE(object_.bearing_evidence(redetected(box, kPedestrianClass), camera_));
  EXPECT_GT(evidence({70, 40, 76, 46}), 0.0) << "within reach";
  EXPECT_LT(evidence({90, 40, 96, 46}), 0.0) << "too far";
}

TEST_F(ObjectStateTest, HasNoPlaceWhereItsFeaturesDisagreeHowFarAwayItIs) {
  std::vector<Feature> features = front({0.3, 0.2, 6.0});
  features.resize(2);
  features[0].u_right_px -= 0.2F * features[0].disparity_px();  // It blends with the foreground.
  object_.begin(track(box_of(features)));
  observe(object_, track(box_of(features)), features);
  EXPECT_FALSE(object_.has_position());
  features[0] = features[1];
  observe(object_, track(box_of(features)), features);
  EXPECT_TRUE(object_.has_position());
}

TEST_F(ObjectStateTest, ItsFeaturesTellHowItMovesWhileMoreAndMoreOfItIsSeen) {
  // Two features at a time: too few for a reconstruction. The last ones are the rearmost.
  constexpr double kAcross_mps = -3.0;
  constexpr int kFrames = 8;
  const auto seen_in = [&](int frame, int part) {
    std::vector<Feature> features = front({0.1 * kAcross_mps * frame - 0.1 * kAcross_mps * part, 0.2, 12.0});
    features.resize(2);
    return features;
  };
  for (int frame = 0; frame < kFrames; ++frame) {
    std::vector<Feature> features = seen_in(frame, frame);
    const std::vector<Feature> before = seen_in(frame - 1, frame);
    for (std::size_t i = 0; i < features.size(); ++i) {
      features[i].age_frames = frame > 0 ? 1 : 0;
      features[i].previous_left_px = before[i].left_px;
    }
    if (frame == 0) {
      object_.begin(track(box_of(features)));
    }
    observe(object_, track(box_of(features)), features);
    camera_.T_world_cam_before = camera_.T_world_cam;
  }
  const double depth_m = object_.prediction(time_ns_, {}).depth_m;
  const double shift_px =
      object_.prediction(time_ns_ + 1'000'000'000, {}).point_px.x() - object_.prediction(time_ns_, {}).point_px.x();
  EXPECT_NEAR(shift_px * depth_m / geometry_.fx_px, kAcross_mps, 1.0);
}

TEST_F(ObjectStateTest, TurnsTheDirectionWithTheCamera) {
  const PixelBox box{60, 40, 68, 46};
  object_.begin(track(box));
  observe(object_, track(box));
  const Se3 turned{so3_exp({0.0, 0.1, 0.0}), Eigen::Vector3d::Zero()};
  const tracking::ObjectPrediction prediction = object_.prediction(time_ns_, turned);
  EXPECT_LT(prediction.point_px.x(), 63.5 - 0.09 * geometry_.fx_px);
}

// The object leaves over the image border and coasts there.
TEST_F(ObjectStateTest, UnseenOnlyASignificantTurnContinues) {
  const auto turned_unseen_rad = [&](ObjectState& object, double turn_radps) {
    Vector6d velocity = Vector6d::Zero();
    velocity[1] = turn_radps;
    velocity[5] = -4.0;
    const Seen last = moves_at_the_border(object, velocity, 20);
    for (int frame = 0; frame < 5; ++frame) {
      observe(object, at_the_border(last.features));
    }
    ObjectResult later;
    object.report(later);
    return so3_log(last.reported.T_world_obj.rotation.transpose() * later.T_world_obj.rotation).norm();
  };
  EXPECT_NEAR(turned_unseen_rad(object_, 0.05), 0.0, 1e-6);
  EXPECT_NEAR(turned_unseen_rad(other_, 0.3), 0.5 * 0.3, 0.01);
}

// A vehicle of which only the side is still seen: where that is has been measured, how it is turned has not.
TEST_F(ObjectStateTest, AnErrorOfItsRotationMovesItsOriginButNotTheMeasuredPart) {
  constexpr std::size_t kColumns = 5;
  const std::vector<Feature> whole = front({0.0, 0.2, 12.0});
  std::vector<Feature> side;
  std::vector<Feature> edge;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (i % kColumns >= kColumns - 2) {
      side.push_back(whole[i]);
    }
    if (i % kColumns == kColumns - 1) {
      edge.push_back(whole[i]);
    }
  }
  object_.begin(track(box_of(whole)));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(whole)), frame < 10 ? whole : side);
  }
  ASSERT_EQ(object_.status(), BodyStatus::kTracked);
  edge = of_another(edge);
  for (int frame = 0; frame < 6; ++frame) {
    observe(object_, track(box_of(edge)), edge);
  }
  ObjectResult last;
  object_.report(last);
  ASSERT_EQ(last.status, BodyStatus::kStereoOnly);
  const StereoObservation seen = observe_stereo({.frame_index = 0, .timestamp_ns = 0, .features = edge}, kLabel, 0.0);
  const Eigen::Vector3d to_side_m = position_in_camera(geometry_, seen) - last.T_world_obj.translation;
  ASSERT_GT(to_side_m.x(), 0.3);
  Matrix6d to_side = Matrix6d::Identity();
  to_side.bottomLeftCorner<3, 3>() = -skew(to_side_m);
  const Matrix6d of_side = to_side * last.covariance * to_side.transpose();
  EXPECT_LT(of_side(5, 5), 0.2 * last.covariance(5, 5)) << "depth";
}

// The object leaves at the image border with a wrong velocity estimate; another vehicle enters there, and the track
// switches to it.
TEST_F(ObjectStateTest, DoesNotCoastAwayFromWhatIsSeen) {
  const Vector6d approaching = (Vector6d() << Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.0, -8.0)).finished();
  ObjectResult reported = moves_at_the_border(object_, approaching, 12).reported;
  const Vector6d wild = (Vector6d() << Eigen::Vector3d::Zero(), Eigen::Vector3d(-10.0, 0.0, -90.0)).finished();
  object_.reinitialise_filter(reported.T_world_obj, wild);
  constexpr double kSecond_z_m = 8.0;
  const std::vector<Feature> second = of_another(front({-0.5, 0.2, kSecond_z_m}));
  for (int frame = 0; frame < 10; ++frame) {
    observe(object_, at_the_border(second), second);
    object_.report(reported);
    const double near_m =
        frame == 0 ? 12.0 : 5.0;  // One frame of the wrong velocity, then the object's width and two metres.
    EXPECT_NEAR(reported.T_world_obj.translation.z(), kSecond_z_m, near_m) << "frame " << frame;
  }
}

TEST_F(ObjectStateTest, StaysWhereItIsWhileAnOccluderFillsItsMaskForAFrame) {
  const std::vector<Feature> own = front({0.0, 0.2, 15.0});
  const PixelBox box = box_of(own);
  const auto depth_m = [&] {
    ObjectResult reported;
    object_.report(reported);
    return reported.T_world_obj.translation.z();
  };
  object_.begin(track(box));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box), own);
  }
  ASSERT_EQ(object_.status(), BodyStatus::kTracked);
  const double before_m = depth_m();
  observe(object_, track(box), of_another(front({0.0, 0.2, 8.0})));
  EXPECT_NEAR(depth_m(), before_m, 0.5);
  for (int frame = 0; frame < 3; ++frame) {
    observe(object_, track(box), own);
  }
  EXPECT_NEAR(depth_m(), before_m, 0.1);
}

// A moving object turns back while mostly occluded, with few features.
TEST_F(ObjectStateTest, CoastsBehindSomethingOnlyWhileThatIsSurerThanWhatIsSeen) {
  const double across_mps = 3.0;
  Vector6d velocity = Vector6d::Zero();
  velocity[3] = across_mps;
  constexpr int kFrames = 12;
  // So near the border that its visible part is no longer than a car.
  const Eigen::Vector3d start_m((2.0 - geometry_.cx_px) / geometry_.fx_px * 15.0 + 0.8, 0.2, 15.0);
  moves_at_the_border(object_, velocity, kFrames, start_m);
  // It turns back while mostly occluded, and only three features are seen.
  Eigen::Vector3d center_m = start_m + 0.1 * (kFrames - 1) * velocity.tail<3>();
  const auto off_m = [&] {
    ObjectResult reported;
    object_.report(reported);
    return std::abs(reported.T_world_obj.translation.x() - center_m.x());
  };
  double farthest_m = 0.0;
  for (int frame = 0; frame < 30; ++frame) {
    center_m.x() -= 0.1 * across_mps;
    std::vector<Feature> features = front(center_m);
    Track seen = track(box_of(features));
    seen.visible_part = 0.4F;
    features.resize(3);
    observe(object_, seen, features);
    farthest_m = std::max(farthest_m, off_m());
  }
  EXPECT_GT(farthest_m, 1.0) << "at first it keeps its velocity";
  EXPECT_LT(off_m(), 4.5) << "what is seen is an end of it; 18 m off at its last velocity";
}

// A distant object probably approaches; then an occluder hides its points, while it moves aside and new points appear
// in every frame.
TEST_F(ObjectStateTest, WhatSeemedToMoveDoesNotRestBehindSomething) {
  const Eigen::Vector3d approach_mps(0.0, 0.0, -3.0);
  const Eigen::Vector3d aside_mps(3.0, 0.0, 0.0);
  constexpr int kSeen = 9;
  constexpr int kHidden = 12;
  // Its observed position has an error in depth, but its speed is still observable.
  const auto seen_at = [](const Eigen::Vector3d& center_m, int frame) {
    return Eigen::Vector3d(center_m + Eigen::Vector3d(0.0, 0.0, frame % 2 == 0 ? 0.8 : -0.8));
  };
  Eigen::Vector3d center_m(-1.0, 0.2, 34.0);
  ObjectResult reported;
  for (int frame = 0; frame < kSeen; ++frame) {
    center_m += 0.1 * approach_mps;
    const std::vector<Feature> features = front(seen_at(center_m, frame));
    if (frame == 0) {
      object_.begin(track(box_of(features)));
    }
    observe(object_, track(box_of(features)), features);
    object_.report(reported);
    object_.describe_motion(0, reported);
    object_.reinitialise_filter(reported.T_world_obj, (Vector6d() << Eigen::Vector3d::Zero(), approach_mps).finished());
  }
  ASSERT_EQ(reported.status, BodyStatus::kTracked);
  ASSERT_FALSE(reported.moving) << "or it keeps a significant velocity";
  const double offset_m = reported.T_world_obj.translation.x() - center_m.x();
  camera_.T_world_cam_before = camera_.T_world_cam;
  for (int frame = 0; frame < kHidden; ++frame) {
    const std::vector<Feature> before = front(center_m);
    center_m += 0.1 * aside_mps;
    std::vector<Feature> features = front(seen_at(center_m, frame));
    for (std::size_t i = 0; i < features.size(); ++i) {
      features[i].id += static_cast<std::uint32_t>(100 * (frame + 1));
      features[i].previous_left_px = before[i].left_px;
    }
    Track seen = track(box_of(features));
    seen.visible_part = 0.4F;
    observe(object_, seen, features);
    object_.report(reported);
  }
  EXPECT_NEAR(reported.T_world_obj.translation.x() - offset_m, center_m.x(), 1.0);
}

// A parked vehicle returns to view under a new track, for a moment; then part of it is seen without features.
TEST_F(ObjectStateTest, WhatRestedStillRestsWhenItIsFoundForAMoment) {
  const Eigen::Vector3d center_m(0.0, 0.2, 10.0);
  const std::vector<Feature> features = front(center_m);
  const PixelBox box = box_of(features);
  object_.begin(track(box));
  for (int frame = 0; frame < 20; ++frame) {
    observe(object_, track(box), features);
  }
  for (int missed = 1; missed <= 20; ++missed) {
    observe(object_, track({}, missed));
  }
  other_.begin(redetected(box));
  other_.continue_from(object_);
  ObjectResult found;
  for (int frame = 0; frame < 3 && found.status != BodyStatus::kTracked; ++frame) {
    observe(other_, track(box), features);
    other_.report(found);
  }
  ASSERT_EQ(found.status, BodyStatus::kTracked);
  PixelBox end = box;  // Large enough to update the state.
  end.x0 += 3 * box.width() / 10;
  for (int frame = 0; frame < 8; ++frame) {
    observe(other_, track(end));
  }
  ObjectResult later;
  other_.report(later);
  EXPECT_LT((later.T_world_obj.translation - found.T_world_obj.translation).norm(), 0.01);
}

// The object leaves over the border and returns there after it was given up, with only one end visible.
TEST_F(ObjectStateTest, WhatComesBackIsWhereItWasCoastingTo) {
  const Eigen::Vector3d velocity_mps(0.0, 0.0, -2.0);
  const Vector6d velocity = (Vector6d() << Eigen::Vector3d::Zero(), velocity_mps).finished();
  const Seen last = moves_at_the_border(object_, velocity, 20);
  const Eigen::Vector3d reported_m = last.reported.T_world_obj.translation;
  int unseen = 0;
  for (ObjectResult now = last.reported; now.status != BodyStatus::kLost; object_.report(now)) {
    observe(object_, at_the_border(last.features));
    ++unseen;
    ASSERT_LT(unseen, 30);
  }
  std::vector<Feature> end = front(Eigen::Vector3d(0.7, 0.2, 15.0) + 0.1 * (20 + unseen) * velocity_mps);
  end.resize(static_cast<std::size_t>(config_.objects.stereo_only_min_features));
  Track seen = at_the_border(end);
  seen.visible_part = 0.3F;
  observe(object_, seen, end);
  ObjectResult back;
  object_.report(back);
  EXPECT_NE(back.status, BodyStatus::kLost);
  EXPECT_NEAR(back.T_world_obj.translation.z(), reported_m.z() + 0.1 * (1 + unseen) * velocity_mps.z(), 0.1);
  const double sigma_m = std::sqrt(back.covariance(3, 3));
  EXPECT_NEAR(back.T_world_obj.translation.x(), reported_m.x(), sigma_m) << "one end says little about the whole";
  EXPECT_LT(sigma_m, 1.5);
}

class WalkerTest : public ObjectStateTest, public ::testing::WithParamInterface<std::size_t> {
 protected:
  /// After two seconds across the view. Every fifth frame lacks a detection.
  ObjectResult after_walking(double speed_mps) {
    ObjectResult reported;
    for (int frame = 0; frame < 20; ++frame) {
      std::vector<Feature> features = front({0.3 - 0.1 * speed_mps * frame, 0.2, 8.0});
      Track seen = track(box_of(features), frame % 5 == 4 ? 1 : 0);
      seen.class_id = kPedestrianClass;
      features.resize(seen.missed_frames == 0 ? GetParam() : 0);
      if (frame == 0) {
        object_.begin(seen);
      }
      observe(object_, seen, features);
    }
    object_.report(reported);
    object_.describe_motion(0, reported);
    return reported;
  }
};

TEST_P(WalkerTest, IsMoving) {
  constexpr double kSpeed_mps = 1.2;
  const ObjectResult reported = after_walking(kSpeed_mps);
  EXPECT_TRUE(reported.moving);
  EXPECT_NEAR(reported.velocity_mps.x(), -kSpeed_mps, 0.2);
}

TEST_P(WalkerTest, IsAtRestWhereItStands) {
  EXPECT_FALSE(after_walking(0.0).moving);
}

// Of a person the outline is measured: two features suffice, that tell how far away it is.
INSTANTIATE_TEST_SUITE_P(Features, WalkerTest, ::testing::Values(2, 6));

class MovingRegionTest : public ObjectStateTest {
 protected:
  /// Frames until a track of this class and velocity is an object; 100 if it never is.
  int frames_to_confirm(segmentation::SegmentationMode mode, std::uint16_t class_id,
                        const Eigen::Vector3d& velocity_mps) {
    config_.segmentation.mode = mode;
    Arena arena(ObjectState::required_bytes(config_) + 100'000);
    ObjectState region = ObjectState::create(config_, geometry_, arena).value();
    FrameResultBuilder output(config_, arena);
    for (int frame = 1; frame < 100; ++frame) {
      const std::vector<Feature> features =
          front(Eigen::Vector3d(0.3, 0.2, 12.0) + 1e-9 * kFrame_ns * frame * velocity_mps);
      Track seen = track(box_of(features));
      seen.class_id = class_id;
      if (frame == 1) {
        region.begin(seen);
      }
      observe(region, seen, features);
      output.set_tracks({&seen, 1}, {&region, 1});
      EXPECT_EQ(output.result().tracks[0].state == TrackState::kConfirmed, region.confirmed());
      if (region.confirmed()) {
        return frame;
      }
    }
    return 100;
  }
};

TEST_F(MovingRegionTest, IsAnObjectOnceItMovesOrOutlastsTheWindow) {
  using segmentation::SegmentationMode;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const Eigen::Vector3d sideways_mps{4.0, 0.0, 0.0};
  const int window = config_.background.window_frames;
  for (const SegmentationMode mode : {SegmentationMode::kMotion, SegmentationMode::kAuto}) {
    EXPECT_EQ(frames_to_confirm(mode, kUnknownClass, none), window + 1) << "with the final result of its first frame";
    EXPECT_LE(frames_to_confirm(mode, kUnknownClass, sideways_mps), window - 2);
    EXPECT_EQ(frames_to_confirm(mode, kVehicleClass, none), 1);
  }
  EXPECT_EQ(frames_to_confirm(SegmentationMode::kMasks, kUnknownClass, none), 1);
}

}  // namespace
}  // namespace kinetrace::pipeline
