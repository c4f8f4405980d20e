// A simulated recording with its truth, and a run folder that holds exactly this truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "rendering/stereo_simulator.hpp"

namespace kinetrace::test {

class TruthRun {
 public:
  static constexpr int kFrames = 10;

  /// Writes the recording of a street with small pictures to `folder`.
  explicit TruthRun(const std::filesystem::path& folder);

  /// The recording, and its truth.
  [[nodiscard]] std::filesystem::path recording() const { return recording_; }
  [[nodiscard]] std::filesystem::path truth() const { return truth_; }

  /// Records the truth from `first_frame` on as a run whose world is the camera of that frame, and whose times are
  /// later.
  void record(const std::filesystem::path& run_folder, int first_frame = 0, std::int64_t later_ns = 0) const;

 private:
  StereoGeometry geometry_;
  std::filesystem::path recording_;
  std::filesystem::path truth_;
  std::vector<simulator::SimulatedFrame> frames_;
};

}  // namespace kinetrace::test
