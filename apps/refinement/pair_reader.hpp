// Random access to a recording's pictures.
#pragma once

#include <cstdint>
#include <functional>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::batch {

/// The rectified pair of a frame; its images are valid until the next call.
using PairReader = std::function<Result<RectifiedPair>(std::int64_t frame)>;

}  // namespace kinetrace::batch
