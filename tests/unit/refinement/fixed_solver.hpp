// A FixedBundleAdjuster with its own memory.
#pragma once

#include <memory>
#include <utility>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"
#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"

namespace kinetrace::refinement {

struct FixedSolver {
  explicit FixedSolver(const FixedBundleConfig& config)
      : arena(FixedBundleAdjuster::required_bytes(config)),
        adjuster(FixedBundleAdjuster::create(config, arena).value()) {}
  Arena arena;
  FixedBundleAdjuster adjuster;
};

/// Enough iterations to reach the optimum to rounding.
inline FixedBundleConfig patient_config() {
  FixedBundleConfig config;
  config.max_iterations = 60;
  config.relative_cost_tolerance = 1e-9;
  return config;
}
inline CeresBundleAdjuster patient_ceres() {
  CeresBundleConfig config;
  config.max_iterations = 200;
  config.relative_cost_tolerance = 1e-12;
  return CeresBundleAdjuster::create(config).value();
}

}  // namespace kinetrace::refinement
