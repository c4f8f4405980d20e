// Tracks reported as moving without a moving object.
#pragma once

#include <span>
#include <vector>

#include "association.hpp"
#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {

[[nodiscard]] std::vector<FalseMovingTrack> find_false_moving(std::span<const ObjectFrame> frames,
                                                              std::span<const FrameAssociation> associations,
                                                              const ObjectConfig& config);

}  // namespace kinetrace::evaluation
