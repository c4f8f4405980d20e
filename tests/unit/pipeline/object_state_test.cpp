// One object slot fed with exact features: no images.
#include "object_state.hpp"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "seen_track.hpp"
#include "street_drive.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::uint8_t kSlot = 0;
constexpr std::uint8_t kLabel = kSlot + 1;

Arena arena_for(const PipelineConfig& config, const StereoGeometry& geometry) {
  return Arena(2 * ObjectState::required_bytes(config) +
               features::FeatureFrontEnd::required_bytes(config.features, geometry.width_px, geometry.height_px));
}

class ObjectStateTest : public ::testing::Test {
 protected:
  ObjectStateTest()
      : config_(test::small_config()),
        geometry_(test::small_rig()),
        arena_(arena_for(config_, geometry_)),
        front_end_(features::FeatureFrontEnd::create(config_.features, geometry_.width_px, geometry_.height_px, arena_)
                       .value()),
        object_(ObjectState::create(config_, geometry_, arena_).value()),
        other_(ObjectState::create(config_, geometry_, arena_).value()) {
    camera_.valid = true;
    camera_.covariance = 1e-8 * Matrix6d::Identity();
  }

  static Track track(const PixelBox& box_px, int missed_frames = 0, std::uint32_t id = 1) {
    return seen_track(id, kSlot, box_px, missed_frames);
  }

  static Track redetected(const PixelBox& box_px, std::uint16_t class_id = kVehicleClass) {
    Track redetected = track(box_px, 0, 2);
    redetected.class_id = class_id;
    return redetected;
  }

  void observe(ObjectState& object, const Track& seen, std::vector<Feature> features = {}) {
    time_ns_ += kFrame_ns;
    object.observe(seen, {.frame_index = 0, .timestamp_ns = time_ns_, .features = features}, {}, camera_, front_end_);
    object.conclude({}, camera_, {});
  }

  /// A grid of features on a front of 1.6 m by 1.2 m around `middle_m`, in the camera's frame.
  std::vector<Feature> front(const Eigen::Vector3d& middle_m) const {
    std::vector<Feature> features;
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 5; ++column) {
        const Eigen::Vector3d p = middle_m + Eigen::Vector3d(0.4 * column - 0.8, 0.4 * row - 0.6, 0.1 * (row % 2));
        const Eigen::Vector3d uvr_px = geometry_.project(p);
        Feature feature;
        feature.slot = static_cast<std::uint16_t>(features.size());
        feature.id = feature.slot + 1U;
        feature.body = kLabel;
        feature.age_frames = 1;
        feature.left_px = uvr_px.head<2>().cast<float>();
        feature.v_px = feature.left_px.y();
        feature.u_right_px = static_cast<float>(uvr_px.z());
        features.push_back(feature);
      }
    }
    return features;
  }

  PixelBox box_of(const std::vector<Feature>& features) const {
    PixelBox box;
    for (const Feature& feature : features) {
      box.include(static_cast<int>(std::lround(feature.left_px.x())),
                  static_cast<int>(std::lround(feature.left_px.y())));
    }
    return box;
  }

  /// Cut off by the left border of the image.
  Track at_the_border(const std::vector<Feature>& features) const {
    Track seen = track(box_of(features));
    seen.box_px.x0 = 0;
    return seen;
  }

  /// What was reported of an object, and what was seen of it, in the last of some frames.
  struct Seen {
    ObjectResult reported;
    std::vector<Feature> features;
  };

  /// Something cut off by the border of the image moves through it for `frames`, and that is learnt: `velocity` in
  /// rad/s, m/s.
  Seen moves_at_the_border(ObjectState& object, const Vector6d& velocity, int frames,
                           const Eigen::Vector3d& start_m = {-0.5, 0.2, 15.0}) {
    Seen seen;
    for (int frame = 0; frame < frames; ++frame) {
      seen.features = front(start_m + 1e-9 * kFrame_ns * frame * velocity.tail<3>());
      if (frame == 0) {
        object.begin(at_the_border(seen.features));
      }
      observe(object, at_the_border(seen.features), seen.features);
      object.report(seen.reported);
      object.learn_motion(seen.reported.T_world_obj, velocity);
    }
    EXPECT_EQ(seen.reported.status, BodyStatus::kTracked);
    return seen;
  }

  PipelineConfig config_;
  StereoGeometry geometry_;
  Arena arena_;
  features::FeatureFrontEnd front_end_;
  ObjectState object_;
  ObjectState other_;
  CameraState camera_;
  std::int64_t time_ns_ = 0;
};

TEST_F(ObjectStateTest, WaitsInItsDirectionWhileItHasNoPlace) {
  const PixelBox box{60, 40, 68, 46};
  object_.begin(track(box));
  observe(object_, track(box));
  const tracking::ObjectPrediction prediction = object_.prediction(time_ns_, camera_.T_world_cam);
  EXPECT_TRUE(prediction.known && prediction.direction_only);
  EXPECT_LT((prediction.point_px - Eigen::Vector2d(63.5, 42.5)).norm(), 1e-6);
  EXPECT_FALSE(object_.bearing_gate(redetected(box), camera_)) << "in view";

  for (int missed = 1; missed <= 4; ++missed) {
    EXPECT_FALSE(object_.bearing_gate(redetected(box), camera_)) << missed;
    observe(object_, track(box, missed));
  }
  EXPECT_TRUE(object_.bearing_gate(redetected(box), camera_));
  EXPECT_FALSE(object_.bearing_gate(redetected(box, kPedestrianClass), camera_));
  EXPECT_TRUE(object_.bearing_gate(redetected({74, 40, 80, 46}), camera_)) << "within reach";
  EXPECT_FALSE(object_.bearing_gate(redetected({90, 40, 96, 46}), camera_)) << "too far";
}

TEST_F(ObjectStateTest, HasNoPlaceWhereItsFeaturesDisagreeHowFarAwayItIs) {
  std::vector<Feature> features = front({0.3, 0.2, 6.0});
  features.resize(2);
  features[0].u_right_px -= 0.2F * features[0].disparity_px();  // It blends with what is in front.
  object_.begin(track(box_of(features)));
  observe(object_, track(box_of(features)), features);
  EXPECT_FALSE(object_.placed());
  features[0] = features[1];
  observe(object_, track(box_of(features)), features);
  EXPECT_TRUE(object_.placed());
}

TEST_F(ObjectStateTest, ItsFeaturesTellHowItMovesWhileMoreAndMoreOfItIsSeen) {
  // Two features at a time: too few to reconstruct it. Those seen last are the ones farthest back.
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
  std::vector<Feature> other = front({-1.5, 0.2, 5.0});
  for (Feature& feature : other) {
    feature.id += 100;
  }
  observe(object_, track(box_of(other)), other);
  ASSERT_TRUE(object_.identity_switched());
  object_.wait_as(track({}, kMissed + 1));
  const Eigen::Vector3d reported_m = last.T_obj_cam.translation;
  object_.revise(kMissed + 1, camera_, last);
  EXPECT_LT((last.T_obj_cam.translation - reported_m).norm(), 0.1) << "a frame is " << 0.1 * kAcross_mps << " m";
}

// Its mask reached over its edge, and its reconstruction began with what stands behind it.
TEST_F(ObjectStateTest, IsNotTrackedWhereMostOfItIsNotSeen) {
  std::vector<Feature> behind = front({0.3, 0.2, 15.0});
  object_.begin(track(box_of(behind)));
  ObjectResult reported;
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(behind)), behind);
  }
  object_.report(reported);
  ASSERT_EQ(reported.status, BodyStatus::kTracked);

  std::vector<Feature> seen = front({0.3, 0.2, 7.0});
  for (Feature& feature : seen) {
    feature.slot = static_cast<std::uint16_t>(feature.slot + behind.size());
    feature.id += 100;
  }
  seen.insert(seen.end(), behind.begin(), behind.begin() + 9);
  bool is_replaced = false;
  for (int frame = 0; frame < 8; ++frame) {
    observe(object_, track(box_of(seen)), seen);
    is_replaced = is_replaced || object_.frame_change() == FrameChange::kReplaced;
  }
  object_.report(reported);
  EXPECT_TRUE(is_replaced);
  EXPECT_NEAR(reported.T_world_obj.translation.z(), 7.0, 0.5);
}

TEST_F(ObjectStateTest, MayComeBackOverTheBorderThatItLeftBy) {
  const std::vector<Feature> features = front({0.3, 0.2, 6.0});
  object_.begin(track(box_of(features)));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(features)), features);
  }
  const int width = geometry_.width_px;
  const int row = geometry_.height_px / 2;
  const PixelBox at_left{0, row - 10, 5, row + 10};
  const PixelBox at_right{width - 5, row - 10, width, row + 10};
  const double half_view_rad = std::atan(0.5 * width / geometry_.fx_px);
  // The camera turns to the right, so that it leaves by the left.
  camera_.T_world_cam.rotation = so3_exp({0.0, 0.1 + half_view_rad, 0.0});
  observe(object_, track({}, 1));
  EXPECT_TRUE(object_.may_come_back_as(redetected(at_left), camera_));
  EXPECT_FALSE(object_.may_come_back_as(redetected(at_left, kPedestrianClass), camera_));
  EXPECT_FALSE(object_.may_come_back_as(redetected(at_right), camera_));
  EXPECT_FALSE(object_.may_come_back_as(redetected({3, row - 10, 8, row + 10}), camera_)) << "not at the border";
  Track seen_before = redetected(at_left);
  seen_before.age_frames = 1;
  EXPECT_FALSE(object_.may_come_back_as(seen_before, camera_)) << "beside it, when it was still seen";
  for (int missed = 2; missed < 12; ++missed) {
    observe(object_, track({}, missed));
  }
  EXPECT_TRUE(object_.may_come_back_as(seen_before, camera_));
  Track for_long = redetected(at_left);
  for_long.age_frames = 6;
  for_long.age_ns = 6 * kFrame_ns + kFrame_ns / 2;
  EXPECT_FALSE(object_.may_come_back_as(for_long, camera_)) << "stereo would have seen it";
  camera_.T_world_cam.rotation.setIdentity();
  EXPECT_FALSE(object_.may_come_back_as(redetected(at_left), camera_)) << "expected in the image";
}

TEST_F(ObjectStateTest, IsRatherWhatIsSeenInItsMiddleThanAnywhereOnIt) {
  const Eigen::Vector3d middle_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(middle_m);
  object_.begin(track(box_of(features)));
  for (int frame = 0; frame < 12; ++frame) {
    observe(object_, track(box_of(features)), features);
  }
  for (int missed = 1; missed <= 5; ++missed) {
    observe(object_, track({}, missed));
  }
  const auto part = [&](double beside_m) {
    return object_.position_gate(middle_m + Eigen::Vector3d(beside_m, 0.0, 0.0), redetected({}), camera_).value_or(2.0);
  };
  EXPECT_LT(part(0.0), part(0.3));
  EXPECT_LT(part(0.3), 0.1) << "both are on it";
  EXPECT_GT(part(8.0), 1.0);
}

TEST_F(ObjectStateTest, IsNotWhatWasSeenBesideIt) {
  const Eigen::Vector3d middle_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(middle_m);
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
  EXPECT_TRUE(object_.position_gate(middle_m, newer, camera_));
  EXPECT_TRUE(other_.bearing_gate(newer, camera_));
  newer.age_frames = 5;
  EXPECT_FALSE(object_.position_gate(middle_m, newer, camera_)) << "first seen when this one was last";
  EXPECT_FALSE(other_.bearing_gate(newer, camera_));
}

TEST_F(ObjectStateTest, TurnsTheDirectionWithTheCamera) {
  const PixelBox box{60, 40, 68, 46};
  object_.begin(track(box));
  observe(object_, track(box));
  const Se3 turned{so3_exp({0.0, 0.1, 0.0}), Eigen::Vector3d::Zero()};
  const tracking::ObjectPrediction prediction = object_.prediction(time_ns_, turned);
  EXPECT_LT(prediction.point_px.x(), 63.5 - 0.09 * geometry_.fx_px);
}

TEST_F(ObjectStateTest, HandsItsNameAndItsBoxOver) {
  const Eigen::Vector3d middle_m(0.3, 0.2, 6.0);
  const std::vector<Feature> features = front(middle_m);
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
  EXPECT_TRUE(other_.placed());
  ObjectResult after;
  other_.report(after);
  other_.describe_motion(0, after);
  EXPECT_EQ(after.box.size_m, before.box.size_m);
}

TEST_F(ObjectStateTest, GoesOnAsItWentWhereItsLastPosesAreTooUncertainToShowIt) {
  // So slow and far that half a second does not show it to move, but a second does.
  const Eigen::Vector3d velocity_mps(0.0, 0.0, 0.8);
  const Vector6d velocity = (Vector6d() << Eigen::Vector3d::Zero(), velocity_mps).finished();
  ObjectResult reported;
  for (int frame = 0; frame < 14; ++frame) {
    const std::vector<Feature> features = front(Eigen::Vector3d(0.2, 0.2, 20.0) + 0.1 * frame * velocity_mps);
    const Track seen = track(box_of(features));
    if (frame == 0) {
      object_.begin(seen);
    }
    observe(object_, seen, features);
    object_.report(reported);
    object_.learn_motion(reported.T_world_obj, velocity);
  }
  ASSERT_EQ(reported.status, BodyStatus::kTracked);
  for (int missed = 1; missed <= 4; ++missed) {
    observe(object_, track({}, missed));
  }
  ObjectResult gone_on;
  object_.report(gone_on);
  EXPECT_NEAR(gone_on.T_world_obj.translation.z() - reported.T_world_obj.translation.z(), 0.4 * velocity_mps.z(), 0.05);
}

// It leaves over the border of the image, and goes on there as it went.
TEST_F(ObjectStateTest, UnseenOnlyAnEvidentTurnGoesOn) {
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

// It leaves the image at the border while its velocity is wrongly known; another vehicle comes in there, and the track
// goes on with that.
TEST_F(ObjectStateTest, DoesNotCoastAwayFromWhatIsSeen) {
  const Vector6d approaching = (Vector6d() << Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.0, -8.0)).finished();
  ObjectResult reported = moves_at_the_border(object_, approaching, 12).reported;
  const Vector6d wild = (Vector6d() << Eigen::Vector3d::Zero(), Eigen::Vector3d(-10.0, 0.0, -90.0)).finished();
  object_.learn_motion(reported.T_world_obj, wild);
  constexpr double kSecond_z_m = 8.0;
  std::vector<Feature> second = front({-0.5, 0.2, kSecond_z_m});
  for (Feature& feature : second) {
    feature.id += 100;
  }
  for (int frame = 0; frame < 10; ++frame) {
    observe(object_, at_the_border(second), second);
    object_.report(reported);
    const double near_m = frame == 0 ? 12.0 : 5.0;  // One frame of the wrong velocity, then its width and two metres.
    EXPECT_NEAR(reported.T_world_obj.translation.z(), kSecond_z_m, near_m) << "frame " << frame;
  }
}

// A parked vehicle comes back into view under a new track, for a moment, and then the rest of it without features.
TEST_F(ObjectStateTest, CoastsBehindSomethingOnlyWhileThatIsSurerThanWhatIsSeen) {
  const double across_mps = 3.0;
  Vector6d velocity = Vector6d::Zero();
  velocity[3] = across_mps;
  constexpr int kFrames = 12;
  // So near the border that what is seen of it is no longer than a car.
  const Eigen::Vector3d start_m((2.0 - geometry_.cx_px) / geometry_.fx_px * 15.0 + 0.8, 0.2, 15.0);
  moves_at_the_border(object_, velocity, kFrames, start_m);
  // Mostly hidden, it turns back, and little of it is seen.
  Eigen::Vector3d middle_m = start_m + 0.1 * (kFrames - 1) * velocity.tail<3>();
  const auto off_m = [&] {
    ObjectResult reported;
    object_.report(reported);
    return std::abs(reported.T_world_obj.translation.x() - middle_m.x());
  };
  double farthest_m = 0.0;
  for (int frame = 0; frame < 30; ++frame) {
    middle_m.x() -= 0.1 * across_mps;
    std::vector<Feature> features = front(middle_m);
    Track seen = track(box_of(features));
    seen.visible_part = 0.4F;
    features.resize(3);
    observe(object_, seen, features);
    farthest_m = std::max(farthest_m, off_m());
  }
  EXPECT_GT(farthest_m, 1.0) << "at first it goes on as it went";
  EXPECT_LT(off_m(), 4.5) << "what is seen is an end of it; 18 m off if it went on so";
}

// Far away it comes nearer, which is likely but not sure; then something comes in front of it and its points are lost,
// while it turns aside and new ones are seen in every frame.
TEST_F(ObjectStateTest, WhatSeemedToMoveDoesNotRestBehindSomething) {
  const Eigen::Vector3d approach_mps(0.0, 0.0, -3.0);
  const Eigen::Vector3d aside_mps(3.0, 0.0, 0.0);
  constexpr int kSeen = 9;
  constexpr int kHidden = 12;
  // Where it is seen errs in depth, but not so much that its speed is anybody's guess.
  const auto seen_at = [](const Eigen::Vector3d& middle_m, int frame) {
    return Eigen::Vector3d(middle_m + Eigen::Vector3d(0.0, 0.0, frame % 2 == 0 ? 0.8 : -0.8));
  };
  Eigen::Vector3d middle_m(-1.0, 0.2, 34.0);
  ObjectResult reported;
  for (int frame = 0; frame < kSeen; ++frame) {
    middle_m += 0.1 * approach_mps;
    const std::vector<Feature> features = front(seen_at(middle_m, frame));
    if (frame == 0) {
      object_.begin(track(box_of(features)));
    }
    observe(object_, track(box_of(features)), features);
    object_.report(reported);
    object_.describe_motion(0, reported);
    object_.learn_motion(reported.T_world_obj, (Vector6d() << Eigen::Vector3d::Zero(), approach_mps).finished());
  }
  ASSERT_EQ(reported.status, BodyStatus::kTracked);
  ASSERT_FALSE(reported.moving) << "or it goes on as it surely went";
  const double offset_m = reported.T_world_obj.translation.x() - middle_m.x();
  camera_.T_world_cam_before = camera_.T_world_cam;
  for (int frame = 0; frame < kHidden; ++frame) {
    const std::vector<Feature> before = front(middle_m);
    middle_m += 0.1 * aside_mps;
    std::vector<Feature> features = front(seen_at(middle_m, frame));
    for (std::size_t i = 0; i < features.size(); ++i) {
      features[i].id += static_cast<std::uint32_t>(100 * (frame + 1));
      features[i].previous_left_px = before[i].left_px;
    }
    Track seen = track(box_of(features));
    seen.visible_part = 0.4F;
    observe(object_, seen, features);
    object_.report(reported);
  }
  EXPECT_NEAR(reported.T_world_obj.translation.x() - offset_m, middle_m.x(), 1.0);
}

TEST_F(ObjectStateTest, WhatRestedStillRestsWhenItIsFoundForAMoment) {
  const Eigen::Vector3d middle_m(0.0, 0.2, 10.0);
  const std::vector<Feature> features = front(middle_m);
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
  PixelBox end = box;  // Not so little that what was known would be left as it is.
  end.x0 += 3 * box.width() / 10;
  for (int frame = 0; frame < 8; ++frame) {
    observe(other_, track(end));
  }
  ObjectResult later;
  other_.report(later);
  EXPECT_LT((later.T_world_obj.translation - found.T_world_obj.translation).norm(), 0.01);
}

// It leaves over the border and comes back there after it has been given up, and only an end of it is seen.
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
  EXPECT_NEAR(back.T_world_obj.translation.x(), reported_m.x(), 0.1);
}

}  // namespace
}  // namespace kinetrace::pipeline
