// Temporarily occluded objects.
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using Eigen::Vector3d;
using test::KeptEstimate;
using test::MaskFolder;
using test::PipelineRun;
using test::RenderedBox;
using test::RenderedPair;
using test::small_config;

constexpr std::uint8_t kObject = 1;
constexpr std::uint8_t kOther = 2;

RenderedBox box_at(const Vector3d& size_m, const Vector3d& centre_m, std::uint8_t label = kBackgroundLabel) {
  RenderedBox box;
  box.size_m = size_m;
  box.T_world_box.translation = centre_m;
  box.label = label;
  return box;
}

/// Boxes in the street in a frame, besides its furniture; the camera creeps ahead.
using Stage = std::function<std::vector<RenderedBox>(int frame)>;

RenderedPair render(const Stage& stage, int frame) {
  static const test::RenderedWorld world;
  std::vector<RenderedBox> boxes = test::street_furniture();
  for (const RenderedBox& box : stage(frame)) {
    boxes.push_back(box);
  }
  return world.render({Eigen::Matrix3d::Identity(), {0.0, 0.0, 0.04 * frame}}, boxes);
}

PipelineRun play(const Stage& stage, int frames) {
  MaskFolder masks;
  std::vector<RenderedPair> pairs;
  for (int frame = 0; frame < frames; ++frame) {
    pairs.push_back(render(stage, frame));
    masks.write(pairs.back(), frame);
  }
  PipelineRun run(small_config(masks));
  for (int frame = 0; frame < frames; ++frame) {
    const std::string stem = test::stem_of(frame);
    run.step(pairs[static_cast<std::size_t>(frame)].at(frame, stem));
  }
  run.drain();
  return run;
}

/// The object's finalised row of a frame; fails where there is none.
const ObjectResult& finalised_row(const PipelineRun& run, int frame, std::uint32_t track_id) {
  static const ObjectResult nothing;
  const ObjectResult* const row = run.finalised.at(static_cast<std::size_t>(frame)).object(track_id);
  EXPECT_NE(row, nullptr) << "frame " << frame;
  return row == nullptr ? nothing : *row;
}

/// The track that shows the object at `centre_m` in a frame, by its box.
std::uint32_t track_near(const PipelineRun& run, int frame, const Vector3d& centre_m) {
  std::uint32_t id = 0;
  double least_m = 1.5;
  for (const ObjectResult& object : run.finalised.at(static_cast<std::size_t>(frame)).objects) {
    if (const double off_m = (object.T_world_obj.translation - centre_m).norm(); off_m < least_m) {
      id = object.track_id;
      least_m = off_m;
    }
  }
  EXPECT_NE(id, 0U) << "frame " << frame;
  return id;
}

TEST(PipelineHiding, WhatStandsStillStaysWhereItIsWhileAnotherPassesInFront) {
  const Vector3d stands(-0.6, 0.5, 8.5);
  const Stage stage = [&](int frame) {
    return std::vector{box_at({1.6, 1.4, 1.5}, stands, kObject),
                       box_at({3.4, 2.0, 0.8}, {-6.5 + 0.3 * frame, 0.4, 6.0}, kOther)};
  };
  const PipelineRun run = play(stage, 44);
  const std::uint32_t id = track_near(run, 6, stands);
  const Vector3d frame_origin_m = finalised_row(run, 6, id).T_world_obj.translation - stands;
  int hidden = 0;
  for (int frame = 6; frame < 44; ++frame) {
    const KeptEstimate& now = run.finalised.at(static_cast<std::size_t>(frame));
    const ObjectResult* const row = now.object(id);
    hidden += row == nullptr || row->status != BodyStatus::kTracked ? 1 : 0;
    if (row != nullptr) {
      EXPECT_LT((row->T_world_obj.translation - stands - frame_origin_m).norm(), 0.03) << "frame " << frame;
      EXPECT_FALSE(row->moving) << "frame " << frame;
    }
  }
  EXPECT_GE(hidden, 10);
  finalised_row(run, 43, id);
}

}  // namespace
}  // namespace kinetrace::pipeline
