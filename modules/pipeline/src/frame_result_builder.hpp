// Builds the published result of a frame.
#pragma once

#include <cstddef>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "object_state.hpp"
#include "result_ring.hpp"

namespace kinetrace::pipeline {

/// Copies confirmed objects, so that buffered ones may still change.
class FrameResultBuilder {
 public:
  /// Memory: two rows, a track and one body per object. The arena may turn out exhausted.
  FrameResultBuilder(const PipelineConfig& config, Arena& arena);

  void set_newest(const BufferedFrame& frame);
  /// Null: no frame has become final.
  void set_finalised(const BufferedFrame* frame);
  void set_bodies(const sfm::BodyReconstruction& background, std::span<const ObjectState> objects);
  void clear_bodies() noexcept { result_.bodies = {}; }
  /// Before release(): a track is confirmed when its object is.
  void set_tracks(std::span<const Track> tracks, std::span<const ObjectState> objects);
  void set_frame(const RectifiedPair& pair, const TrackFrame& tracks, const FrameCounters& counters);
  void set_rig(const RigEstimate& rig) { result_.rig = rig; }
  /// After the last frame: no tracks and images.
  void clear_frame() noexcept;

  [[nodiscard]] const FrameResult& result() const noexcept { return result_; }

 private:
  std::span<ObjectResult> newest_objects_;
  std::span<ObjectResult> finalised_objects_;
  std::span<BodyGeometry> bodies_;
  std::span<Track> tracks_;
  FrameResult result_;
};

}  // namespace kinetrace::pipeline
