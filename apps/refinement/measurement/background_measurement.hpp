// The background's points, measured again in the recording's pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>
#include <vector>

#include "../pair_reader.hpp"
#include "disparity_change.hpp"
#include "kinetrace/recording/observations.hpp"

namespace kinetrace::batch {

struct MeasuredBackground {
  /// By frame, in place of those of the run. Frames that are not in here are as the run has them.
  std::unordered_map<std::int64_t, std::vector<recording::Observation>> frames;
  /// By frame, of those frames: what the right camera as it stands at the end changes for everything else that was
  /// seen.
  std::unordered_map<std::int64_t, DisparityChange> changes;
  /// A point that looked too different to be the same goes on as a new one: of which it was a part.
  std::map<std::uint32_t, std::uint32_t> part_of;

  /// Zero for frames that are as the run has them.
  [[nodiscard]] DisparityChange change_in(std::int64_t frame) const {
    const auto found = changes.find(frame);
    return found == changes.end() ? DisparityChange() : found->second;
  }
};

struct MeasurementOptions {
  std::function<bool()> keep_going = {};
  std::function<void(std::size_t rows)> progress = {};
};

/// Aligns all observations of a point, left and right, with one template, that of the frame which saw it first; from
/// frame to frame, errors stay with a point for some frames and do not average out. The right camera stands as
/// `run.applied` says at the end of the run. Pictures that cannot be read leave their frame as it is. Memory: 24 bytes
/// an observation, 10 KiB for each point in sight. Errors: those of ObservationReader.
[[nodiscard]] Result<MeasuredBackground> measure_background(const recording::Run& run, const PairReader& read,
                                                            const MeasurementOptions& options);

}  // namespace kinetrace::batch
