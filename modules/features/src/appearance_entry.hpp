// One remembered point: see AppearanceMemory.
#pragma once

#include "feature_slot.hpp"
#include "kinetrace/features/appearance_memory.hpp"

namespace kinetrace::features {

struct AppearanceMemory::Entry {
  std::uint32_t feature_id;
  std::uint32_t note;  ///< Number of the note that it was last taken in.
  Eigen::Vector3f p_body;
  float disparity_px;  ///< Stands for its size.
  PatchMask own;
  ReferencePatch patch;
};

}  // namespace kinetrace::features
