#include "centre_alignment.hpp"

#include "kernels.hpp"
#include "patch_gate.hpp"

namespace kinetrace::features {
namespace {

// The two sides of a contour move relative to each other by little more while both still resemble the patch; a larger
// shift is a mismatch.
constexpr float kMaxShift_px = 1.5F;
constexpr float kConverged_px = 0.01F;

}  // namespace

void align_centre(const Plane& image, const AlignOptions& options, PatchTemplate& patch,
                  Eigen::Vector2f& position) noexcept {
  AlignOptions near = options;
  near.max_shift_px = kMaxShift_px;
  near.converged_px = kConverged_px;
  kernels().patch_template.narrow(&patch);
  Eigen::Vector2f found = position;
  if (kernels().patch.align(image, patch, near, &found.x(), &found.y()) && patch_inside(image, found)) {
    position = found;
  }
}

}  // namespace kinetrace::features
