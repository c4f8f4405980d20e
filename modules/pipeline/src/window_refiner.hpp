// Bundle adjustment of several bodies in one frame: they are independent, so they are adjusted in parallel.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"

namespace kinetrace::pipeline {

/// A body whose window is to be adjusted, and the result.
struct BodyRefinement {
  sfm::BodyReconstruction* body = nullptr;
  BundleSummary summary;
};

class WindowRefiner {
 public:
  /// Memory: an adjuster for windows as large as `largest`, and one for objects', with any number of workers. `workers`
  /// must outlive this; null: the calling thread does it alone, with the same result.
  [[nodiscard]] static Result<WindowRefiner> create(const refinement::FixedBundleConfig& largest,
                                                    const sfm::BodyConfig& object, Arena& arena, Workers* workers);
  [[nodiscard]] static std::size_t required_bytes(const refinement::FixedBundleConfig& largest,
                                                  const sfm::BodyConfig& object);

  /// Adjusts the window of each body in place: the first may be as large as `largest`, the others are objects. On an
  /// error of one body, others may have been adjusted. Does not allocate except for an error.
  [[nodiscard]] Status refine(std::span<BodyRefinement> bodies);
  /// As FixedBundleAdjuster::limit.
  void limit(int max_iterations) noexcept;

 private:
  static constexpr std::size_t kAdjusters = 2;

  WindowRefiner(refinement::FixedBundleAdjuster first, refinement::FixedBundleAdjuster second, Workers* workers)
      : adjusters_{std::move(first), std::move(second)}, workers_(workers) {}
  [[nodiscard]] static Status refine_one(refinement::FixedBundleAdjuster& adjuster, BodyRefinement& body);

  std::array<refinement::FixedBundleAdjuster, kAdjusters> adjusters_;
  Workers* workers_;
};

}  // namespace kinetrace::pipeline
