// Background points, measured again in the recording's pictures.
#pragma once

#include <cstddef>
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
  /// By frame, instead of the run's observations. Frames that are not in here keep the run's.
  std::unordered_map<std::int64_t, std::vector<recording::Observation>> frames;
  /// By frame, of those frames: the change of all other disparities by the right camera's final pose.
  std::unordered_map<std::int64_t, DisparityChange> changes;
  /// A point whose appearance changed too much was split: the original id of each new point.
  std::map<std::uint32_t, std::uint32_t> part_of;
  std::size_t frames_without_images = 0;  ///< Of those that the run has observations of.

  /// Zero for frames that keep the run's observations.
  [[nodiscard]] DisparityChange change_in(std::int64_t frame) const {
    const auto found = changes.find(frame);
    return found == changes.end() ? DisparityChange() : found->second;
  }
};

struct MeasurementOptions {
  std::function<bool()> keep_going = {};
  std::function<void(std::size_t rows)> progress = {};
};

/// Aligns all observations of a point, left and right, with one template from its first frame; errors of frame-to-frame
/// tracking persist with a point for some frames and do not average out. The right camera has its pose at the end of
/// the run, `run.applied`. Frames whose pictures cannot be read are not changed. Memory: 24 bytes an observation, 10
/// KiB for each visible point. Errors: those of ObservationReader.
[[nodiscard]] Result<MeasuredBackground> measure_background(const recording::Run& run, const PairReader& read,
                                                            const MeasurementOptions& options);

}  // namespace kinetrace::batch
