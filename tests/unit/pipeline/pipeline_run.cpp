#include "pipeline_run.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace kinetrace::test {
namespace {

KeptEstimate kept(const FrameEstimate& estimate) {
  return {
      estimate.frame_index, estimate.timestamp_ns, estimate.camera, {estimate.objects.begin(), estimate.objects.end()}};
}

KeptPoints points_of(const FrameResult& result) {
  KeptPoints points;
  for (const BodyGeometry& body : result.bodies) {
    for (const BodyPoint& point : body.points) {
      if (point.observations >= 2) {
        points.live.emplace_back(body.track_id, point.id);
      }
    }
    for (const BodyPoint& point : body.retired) {
      points.retired.emplace_back(body.track_id, point.id);
    }
  }
  return points;
}

std::size_t planned_bytes(const pipeline::PipelineConfig& config, const StereoGeometry& geometry) {
  const auto plan = pipeline::Pipeline::plan(config, geometry);
  EXPECT_TRUE(plan) << plan.error().message;
  return plan ? plan->total_bytes() : 0;
}

}  // namespace

const ObjectResult* KeptEstimate::object(std::uint32_t track_id) const {
  const auto found =
      std::find_if(objects.begin(), objects.end(), [&](const ObjectResult& o) { return o.track_id == track_id; });
  return found == objects.end() ? nullptr : &*found;
}

PipelineRun::PipelineRun(const pipeline::PipelineConfig& config, const StereoGeometry& geometry, Workers* workers)
    : arena_(planned_bytes(config, geometry)) {
  auto made = pipeline::Pipeline::create(config, geometry, arena_, {}, workers);
  EXPECT_TRUE(made) << made.error().message;
  pipeline_ = std::make_unique<pipeline::Pipeline>(std::move(made.value()));
}

const FrameResult& PipelineRun::step(const RectifiedPair& pair) {
  const Result<const FrameResult*> result = pipeline_->process(pair);
  EXPECT_TRUE(result) << result.error().message;
  const FrameResult& now = *result.value();
  keep_finalised(now);
  newest.push_back(kept(now.newest));
  const auto not_ascending = [](const Track& a, const Track& b) { return a.id >= b.id; };
  EXPECT_EQ(std::adjacent_find(now.tracks.begin(), now.tracks.end(), not_ascending), now.tracks.end())
      << "tracks of frame " << now.newest.frame_index;
  tracks.emplace_back(now.tracks.begin(), now.tracks.end());
  points.push_back(points_of(now));
  return now;
}

void PipelineRun::drive(const StreetDrive& street, int first, int end) {
  for (int frame = first; frame < end; ++frame) {
    const std::string stem = stem_of(frame);
    step(street.render(frame).at(frame, stem));
  }
}

void PipelineRun::drain() {
  while (const FrameResult* result = pipeline_->drain()) {
    keep_finalised(*result);
    const std::vector<PointKey> retired = points_of(*result).retired;
    drained.insert(drained.end(), retired.begin(), retired.end());
  }
}

void PipelineRun::keep_finalised(const FrameResult& result) {
  counters = result.counters;
  if (result.has_finalised) {
    finalised.push_back(kept(result.finalised));
  }
}

std::vector<std::uint32_t> object_ids(const std::vector<KeptEstimate>& estimates) {
  std::set<std::uint32_t> ids;
  for (const KeptEstimate& estimate : estimates) {
    for (const ObjectResult& object : estimate.objects) {
      ids.insert(object.track_id);
    }
  }
  return {ids.begin(), ids.end()};
}

double worst_camera_error_m(const std::vector<KeptEstimate>& finalised) {
  double worst = 0.0;
  for (const KeptEstimate& estimate : finalised) {
    const Se3 truth = StreetDrive::T_world_cam(static_cast<int>(estimate.frame_index));
    worst = std::max(worst, (estimate.camera.T_world_cam.translation - truth.translation).norm());
  }
  return worst;
}

}  // namespace kinetrace::test
