// Association of tracks with objects, frame by frame.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {

/// Indices into ObjectFrame::tracks, one for each of ObjectFrame::truth.
struct FrameAssociation {
  std::vector<std::optional<std::size_t>> matched;
  /// The same, but unmatched objects get their last track if it is in the frame and not matched to another.
  std::vector<std::optional<std::size_t>> followed;
};

[[nodiscard]] std::vector<FrameAssociation> associate(std::span<const ObjectFrame> frames, double min_similarity);

}  // namespace kinetrace::evaluation
