// The configuration that the modules get.
#pragma once

#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::pipeline {

/// Fills in what follows from other settings, so that each is set once.
[[nodiscard]] PipelineConfig resolved(const PipelineConfig& config);

}  // namespace kinetrace::pipeline
