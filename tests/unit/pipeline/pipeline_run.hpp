// A pipeline with its arena, and copies of all its results.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "street_drive.hpp"

namespace kinetrace::test {

/// A frame's estimate that outlives the pipeline's next call.
struct KeptEstimate {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  CameraResult camera;
  std::vector<ObjectResult> objects;

  [[nodiscard]] const ObjectResult* object(std::uint32_t track_id) const;
};

/// A point by its track and its own id.
using PointKey = std::pair<std::uint32_t, std::uint32_t>;

/// Points of all bodies of one result.
struct KeptPoints {
  std::vector<PointKey> live;  ///< Seen at least twice, hence kept.
  std::vector<PointKey> retired;
};

class PipelineRun {
 public:
  explicit PipelineRun(const pipeline::PipelineConfig& config, const StereoGeometry& geometry = small_rig(),
                       Workers* workers = nullptr);

  /// Processes a frame and keeps its results; fails the test on an error.
  const FrameResult& step(const RectifiedPair& pair);
  /// Frames [`first`, `end`) of a drive, named like its mask files.
  void drive(const StreetDrive& street, int first, int end);
  void drain();

  [[nodiscard]] pipeline::Pipeline& pipeline() { return *pipeline_; }
  /// Of each frame, as it was when it was the newest.
  std::vector<KeptEstimate> newest;
  std::vector<KeptEstimate> finalised;
  /// Of each processed frame.
  std::vector<std::vector<Track>> tracks;
  std::vector<KeptPoints> points;  ///< Of each processed frame.
  std::vector<PointKey> drained;   ///< Retired while draining.
  FrameCounters counters;

 private:
  void keep_finalised(const FrameResult& result);

  Arena arena_;
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

/// Ids of all objects in these estimates, ascending.
[[nodiscard]] std::vector<std::uint32_t> object_ids(const std::vector<KeptEstimate>& estimates);

/// Largest distance between the finalised camera path and the drive's.
[[nodiscard]] double worst_camera_error_m(const std::vector<KeptEstimate>& finalised);

}  // namespace kinetrace::test
