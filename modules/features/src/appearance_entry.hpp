// One remembered point: see AppearanceMemory.
#pragma once

#include "feature_slot.hpp"
#include "kinetrace/features/appearance_memory.hpp"

namespace kinetrace::features {

struct AppearanceMemory::Entry {
  Eigen::Vector3f p_body;
  float disparity_px;  ///< Stands for its size.
  PatchMask own;
  ReferencePatch patch;
};

}  // namespace kinetrace::features
