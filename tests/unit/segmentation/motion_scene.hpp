// Runs motion segmentation on a simulated world and scores its masks against the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/segmentation/motion_segmenter.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::segmentation {

/// Score of one frame's detections against the true bodies of features.
struct SceneScore {
  std::size_t detections = 0;
  std::size_t moving = 0;               ///< Of these, moving in this frame.
  std::vector<std::size_t> hits;        ///< Per object: detections in which most features are its own.
  std::vector<double> coverage;         ///< Per object: share of its features that its detections hold.
  std::size_t background_in_masks = 0;  ///< Static features, right and wrong ones, on any mask.
  std::size_t empty_detections = 0;     ///< Detections in which most features belong to no object.
};

class MotionScene {
 public:
  explicit MotionScene(const test::WorldConfig& world, std::vector<test::SyntheticObject> objects = {},
                       const MotionConfig& motion = {}, int max_objects = 16)
      : geometry_(world.geometry), object_count_(objects.size()), world_(world, std::move(objects)) {
    SegmentationConfig config;
    config.mode = SegmentationMode::kMotion;
    config.motion = motion;
    config.max_objects = max_objects;
    arena_ = std::make_unique<Arena>(MotionSegmenter::required_bytes(config, geometry_, world.capacity));
    auto made = MotionSegmenter::create(config, geometry_, world.capacity, *arena_);
    EXPECT_TRUE(made.has_value()) << made.error().message;
    segmenter_ = std::move(*made);
  }

  /// Features on all masks have the same label, as if a tracker merged all masks into one object.
  bool one_body = false;

  /// One frame with the camera and the objects at the given poses. Features have the label of their mask in the
  /// previous frame; as in the feature front end, a feature whose label changes is replaced by a new one.
  SceneScore step(const Se3& T_world_cam, std::span<const Se3> T_world_obj = {}, bool ego_valid = true) {
    const FeatureFrame frame = world_.observe(T_world_cam, T_world_obj);
    truth_.clear();
    for (Feature& f : frame.features) {
      truth_.push_back(f.body);
      relabel(f);
    }
    SegmentationInput input;
    input.pair.frame_index = frame.frame_index;
    input.pair.timestamp_ns = frame.timestamp_ns;
    input.pair.geometry = geometry_;
    input.features = frame.features;
    input.ego_valid = ego_valid && frame.frame_index > 0;
    input.T_prev_cam = T_world_prev_.inverse() * T_world_cam;
    T_world_prev_ = T_world_cam;
    const auto result = segmenter_->process(input);
    EXPECT_TRUE(result.has_value());
    last_ = *result;
    return score(frame.features);
  }

  [[nodiscard]] const DetectionFrame& last() const { return last_; }
  [[nodiscard]] MotionSegmenter& segmenter() { return *segmenter_; }
  [[nodiscard]] test::SyntheticWorld& world() { return world_; }

 private:
  void relabel(Feature& f) {
    Replacement& known = replacements_[f.slot];
    f.body = f.age_frames > 0 ? label_at(f.previous_left_px) : kBackgroundLabel;
    f.body = one_body ? std::min<std::uint8_t>(f.body, 1) : f.body;
    if (known.original_id != f.id) {
      known = {f.id, f.id, f.body, 0};
    } else if (known.body != f.body) {
      known = {f.id, next_replacement_id_++, f.body, f.age_frames - 1};
    }
    f.id = known.id;
    f.age_frames -= std::min(f.age_frames, known.born_at_age);
  }

  [[nodiscard]] std::uint8_t label_at(const Eigen::Vector2f& p) const {
    const int x = static_cast<int>(std::lround(p.x()));
    const int y = static_cast<int>(std::lround(p.y()));
    return last_.left_labels.contains(x, y) ? last_.left_labels.at(x, y) : kBackgroundLabel;
  }

  [[nodiscard]] SceneScore score(std::span<const Feature> features) const {
    SceneScore out;
    out.detections = last_.left.size();
    out.moving = static_cast<std::size_t>(
        std::count_if(last_.left.begin(), last_.left.end(), [](const Detection& d) { return d.moving; }));
    out.hits.resize(object_count_);
    out.coverage.resize(object_count_);
    std::vector<std::vector<int>> count(last_.left.size() + 1, std::vector<int>(object_count_ + 1));
    for (std::size_t i = 0; i < features.size(); ++i) {
      ++count[label_at(features[i].left_px)][truth_[i]];
    }
    for (std::size_t label = 1; label < count.size(); ++label) {
      const auto most = std::max_element(count[label].begin(), count[label].end()) - count[label].begin();
      out.background_in_masks += static_cast<std::size_t>(count[label][0]);
      if (most == 0) {
        ++out.empty_detections;
      } else {
        const auto object = static_cast<std::size_t>(most - 1);
        ++out.hits[object];
        out.coverage[object] += count[label][static_cast<std::size_t>(most)];
      }
    }
    for (std::size_t object = 0; object < object_count_; ++object) {
      int total = 0;
      for (const auto& on_label : count) {
        total += on_label[object + 1];
      }
      out.coverage[object] /= std::max(1, total);
    }
    return out;
  }

  struct Replacement {
    std::uint32_t original_id = 0;
    std::uint32_t id = 0;
    std::uint8_t body = 0;
    std::uint32_t born_at_age = 0;
  };

  StereoGeometry geometry_;
  std::size_t object_count_ = 0;
  test::SyntheticWorld world_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<MotionSegmenter> segmenter_;
  Se3 T_world_prev_;
  DetectionFrame last_;
  std::vector<std::uint8_t> truth_;
  std::map<std::uint16_t, Replacement> replacements_;
  std::uint32_t next_replacement_id_ = 1U << 30U;
};

}  // namespace kinetrace::segmentation
