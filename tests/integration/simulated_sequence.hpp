// A simulated scene with small images, and the pipeline's results on it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "rendering/stereo_simulator.hpp"

namespace kinetrace::test {

struct FollowedFrame {
  Se3 T_world_cam_true;
  CameraResult camera;
  std::vector<ObjectResult> objects;
};

struct Followed {
  std::vector<FollowedFrame> finalised;
  FrameCounters counters;
  RigEstimate rig;
};

class SimulatedSequence {
 public:
  /// Renders `frames` of the scene into `folder`, with pictures `width_px` wide and masks as a network gives them.
  SimulatedSequence(const std::filesystem::path& folder, const std::string& scene, int frames, int width_px,
                    const simulator::RigErrors& errors = {}, std::uint32_t seed = 1);

  /// Default settings, with these masks.
  [[nodiscard]] pipeline::PipelineConfig masked() const;
  /// Default settings; objects are found by their motion.
  [[nodiscard]] static pipeline::PipelineConfig by_motion();

  /// Plays everything; fails the test on an error or an allocation after start.
  [[nodiscard]] Followed follow(const pipeline::PipelineConfig& config) const;

 private:
  std::filesystem::path folder_;
  std::filesystem::path drive_;
  std::vector<Se3> T_world_cam_;
};

}  // namespace kinetrace::test
