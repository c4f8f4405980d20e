// One object slot fed with exact features: no images.
#pragma once

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "object_state.hpp"
#include "seen_track.hpp"
#include "street_drive.hpp"

namespace kinetrace::pipeline {

inline constexpr std::uint8_t kSlot = 0;
inline constexpr std::uint8_t kLabel = kSlot + 1;

class ObjectStateTest : public ::testing::Test {
 protected:
  ObjectStateTest()
      : config_(test::small_config()),
        geometry_(test::small_rig()),
        arena_(2 * ObjectState::required_bytes(config_)),
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
    object.observe(seen, {.frame_index = 0, .timestamp_ns = time_ns_, .features = features}, {}, camera_);
    object.conclude({}, camera_, {});
  }

  /// A grid of features on a front of 1.6 m by 1.2 m around `center_m`, in the camera's frame.
  std::vector<Feature> front(const Eigen::Vector3d& center_m) const {
    std::vector<Feature> features;
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 5; ++column) {
        const Eigen::Vector3d p = center_m + Eigen::Vector3d(0.4 * column - 0.8, 0.4 * row - 0.6, 0.1 * (row % 2));
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

  /// The same positions on another object: other slots and ids.
  static std::vector<Feature> of_another(std::vector<Feature> features) {
    for (Feature& feature : features) {
      feature.slot = static_cast<std::uint16_t>(feature.slot + 100U);
      feature.id += 100;
    }
    return features;
  }

  /// Four features at this place, camera frame.
  StereoObservation stereo_at(const Eigen::Vector3d& p_cam) const {
    const Eigen::Vector3d uvr_px = geometry_.project(p_cam);
    return {.features = 4, .uvd_px = {uvr_px.x(), uvr_px.y(), uvr_px.x() - uvr_px.z()}, .agreeing = 4, .motion = {}};
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

  /// Report and observed features of an object in the last of some frames.
  struct Seen {
    ObjectResult reported;
    std::vector<Feature> features;
  };

  /// An object truncated by the image border moves for `frames` frames with `velocity` (rad/s, m/s), which the object
  /// state learns.
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
      object.reinitialise_filter(seen.reported.T_world_obj, velocity);
    }
    EXPECT_EQ(seen.reported.status, BodyStatus::kTracked);
    return seen;
  }

  PipelineConfig config_;
  StereoGeometry geometry_;
  Arena arena_;
  ObjectState object_;
  ObjectState other_;
  CameraState camera_;
  std::int64_t time_ns_ = 0;
};

}  // namespace kinetrace::pipeline
