// Interface of the hot kernel: plain data only, since its source is compiled for several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kinetrace/core/stereo_reprojection.hpp"

namespace kinetrace::refinement {

inline constexpr int kLanes = 8;       ///< Points worked on at once, one per vector lane.
inline constexpr int kLaneBytes = 32;  ///< Alignment of every struct of lanes: a vector type's own depends on the
                                       ///< instruction set.
using Float8 __attribute__((vector_size(32))) = float;

/// Observations of the eight points of a group in one frame. Weight 0: this lane's point is not observed.
struct alignas(kLaneBytes) ObservationLanes {
  Float8 u_left_px, v_px, u_right_px;
  Float8 left_weight;   ///< 1 / sigma^2 of u_left and v.
  Float8 right_weight;  ///< 1 / sigma^2 of u_right, 0 where only the left view saw the point.
};

/// Eight points in the anchor frame.
struct alignas(kLaneBytes) PointLanes {
  Float8 x, y, z;
};

/// Eight points that mostly share their frames.
struct PointGroup {
  std::uint32_t frames = 0;             ///< Union of the lanes' frames.
  std::uint32_t first_observation = 0;  ///< One ObservationLanes for each bit of `frames`, from the lowest.
};

/// Data of eight eliminated points for back-substitution.
struct alignas(kLaneBytes) PointFactor {
  Float8 inverse_cholesky[6];  ///< Lower triangle, row by row, of L^-1 with L L^T = the damped Hessian of the point.
  Float8 gradient[3];
};

/// T_cam_anchor, row-major.
struct KernelPose {
  float rotation[9];
  float translation[3];
};

/// Normal equations of one free frame, summed over points lane by lane; left perturbation of T_cam_anchor.
struct alignas(kLaneBytes) FrameSums {
  Float8 hessian[21];          ///< Lower triangle, row by row, without the eliminated points.
  Float8 reduced_gradient[6];  ///< With the points eliminated.
};

/// Schur complement of the points in one 6 x 6 block of the camera system (to be subtracted), row-major, lane by lane.
struct alignas(kLaneBytes) BlockSums {
  Float8 entry[36];
};

/// Index of block (row, column <= row) in the lower triangle.
[[nodiscard]] constexpr int block_index(int row, int column) noexcept {
  return row * (row + 1) / 2 + column;
}

/// Input of the kernel. Nothing is owned.
struct KernelProblem {
  ReprojectionModel<float> model;
  float min_depth_m = 0.F;
  float robust_scale = 0.F;  ///< Square of the loss's threshold, in sigmas (see robust_loss.hpp).
  float behind_loss = 0.F;   ///< Robust loss of an observation behind the camera.
  const KernelPose* poses = nullptr;
  const int* free_index = nullptr;  ///< Per frame: place in the camera system, -1 where fixed.
  int free_frames = 0;
  const PointGroup* groups = nullptr;
  int group_count = 0;
  const ObservationLanes* observations = nullptr;
  const PointLanes* points = nullptr;
};

/// The kernel's two passes over all points, for one instruction set.
struct BundleKernel {
  /// Linearises, eliminates the points with their Hessians' diagonals raised by the fraction `damping`, and returns the
  /// cost (sum of the robust loss / 2). Overwrites `factors` [group], `frames` [free frame] and `blocks` [block_index].
  double (*eliminate_points)(const KernelProblem& problem, float damping, PointFactor* factors, FrameSums* frames,
                             BlockSums* blocks);
  /// Back-substitutes the camera step [6 * free frame], writes the moved points to `moved` [group] and returns the cost
  /// at `moved_poses` and `moved`.
  double (*move_points)(const KernelProblem& problem, const PointFactor* factors, const float* camera_step,
                        const KernelPose* moved_poses, PointLanes* moved);
};

/// Cholesky factorisation of a symmetric positive definite matrix, for one instruction set.
struct CholeskyKernel {
  /// Replaces the lower triangle of `a` (row-major, rows `stride` doubles apart) by its Cholesky factor. False, with
  /// `a` invalid, if a pivot is not positive.
  bool (*factorise)(double* a, std::ptrdiff_t size, std::ptrdiff_t stride);
  /// Solves L L^T x = b in place.
  void (*solve)(const double* l, std::ptrdiff_t size, std::ptrdiff_t stride, double* b);
};

namespace kernel_baseline {
extern const BundleKernel bundle_kernel;
extern const CholeskyKernel cholesky_kernel;
}  // namespace kernel_baseline
namespace kernel_fast {
extern const BundleKernel bundle_kernel;
extern const CholeskyKernel cholesky_kernel;
}  // namespace kernel_fast

}  // namespace kinetrace::refinement
