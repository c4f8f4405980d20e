// One remembered point: see AppearanceMemory.
#pragma once

#include "feature_slot.hpp"
#include "kinetrace/features/appearance_memory.hpp"

namespace kinetrace::features {

struct AppearanceMemory::Entry {
  std::uint32_t feature_id;
  std::uint32_t note;  ///< Number of the last note that contained it.
  Eigen::Vector3f p_body;
  float disparity_px;  ///< Stands for its scale.
  PatchMask own;
  ReferencePatch patch;
};

}  // namespace kinetrace::features
