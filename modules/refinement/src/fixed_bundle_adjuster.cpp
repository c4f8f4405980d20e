#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "bundle_kernel.hpp"
#include "kinetrace/core/cpu.hpp"
#include "packed_window.hpp"
#include "robust_loss.hpp"
#include "turn_residual.hpp"
#include "window_check.hpp"

namespace kinetrace::refinement {

struct FixedBundleStorage {
  PackedWindow window;
  std::span<KernelPose> poses;
  std::span<KernelPose> moved_poses;
  std::span<Se3> moved_T_cam_anchor;
  std::span<PointLanes> moved_points;
  std::span<PointFactor> factors;
  std::span<FrameSums> frames;
  std::span<BlockSums> blocks;
  std::span<double> system;  ///< Reduced camera system, lower triangle, rows of `system_stride`.
  std::span<double> step;
  std::span<float> kernel_step;
};

namespace {

constexpr double kMinDamping = 1e-6;  ///< Below, damping drowns in the rounding of single precision.
constexpr double kMaxDamping = 1e6;
constexpr double kDampingDown = 0.1;
constexpr double kDampingUp = 10.0;
/// An unobserved pose stays, with a covariance of (1000 rad or m)^2.
constexpr double kPriorInformation = 1e-6;
constexpr int kPoseSize = 6;

Status out_of_range(const std::string& key, const std::string& range, double value) {
  std::string text = std::to_string(value);
  return fail(ErrorCode::kInvalidConfig, "refinement." + key + " must be in " + range + ", got " + text);
}

FixedBundleStorage carve(const FixedBundleConfig& config, Arena& arena) {
  const auto frames = static_cast<std::size_t>(config.max_frames);
  FixedBundleStorage s;
  s.window = PackedWindow(arena, config.max_frames, config.max_points);
  const std::size_t groups = (static_cast<std::size_t>(config.max_points) + kLanes - 1) / kLanes;
  s.poses = arena.take<KernelPose>(frames);
  s.moved_poses = arena.take<KernelPose>(frames);
  s.moved_T_cam_anchor = arena.take<Se3>(frames);
  s.moved_points = arena.take<PointLanes>(groups);
  s.factors = arena.take<PointFactor>(groups);
  s.frames = arena.take<FrameSums>(frames);
  s.blocks = arena.take<BlockSums>(static_cast<std::size_t>(block_index(config.max_frames, 0)));
  s.system = arena.take<double>(frames * kPoseSize * frames * kPoseSize);
  s.step = arena.take<double>(frames * kPoseSize);
  s.kernel_step = arena.take<float>(frames * kPoseSize);
  return s;
}

double sum_lanes(const Float8& lanes) {
  double sum = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) {
    sum += static_cast<double>(lanes[lane]);
  }
  return sum;
}

KernelPose kernel_pose(const Se3& pose) {
  KernelPose out{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      out.rotation[3 * r + c] = static_cast<float>(pose.rotation(r, c));
    }
    out.translation[r] = static_cast<float>(pose.translation[r]);
  }
  return out;
}

const BundleKernel& bundle_kernel() {
  return cpu_runs_fast_kernels() ? kernel_fast::bundle_kernel : kernel_baseline::bundle_kernel;
}

const CholeskyKernel& cholesky_kernel() {
  return cpu_runs_fast_kernels() ? kernel_fast::cholesky_kernel : kernel_baseline::cholesky_kernel;
}

/// Refinement of one window.
class Refinement {
 public:
  Refinement(const FixedBundleConfig& config, const BundleWindow& window, FixedBundleStorage& storage)
      : config_(config), turns_(window.turns), s_(storage), size_(kPoseSize * storage.window.free_frames) {
    const StereoGeometry& geometry = window.geometry;
    problem_.model = {static_cast<float>(geometry.fx_px), static_cast<float>(geometry.fy_px),
                      static_cast<float>(geometry.cx_px), static_cast<float>(geometry.cy_px),
                      static_cast<float>(geometry.fx_px * geometry.baseline_m)};
    problem_.min_depth_m = static_cast<float>(kMinDepthBaselines * geometry.baseline_m);
    const double threshold = config.robust_threshold_sigmas;
    problem_.robust_scale = static_cast<float>(threshold * threshold);
    problem_.behind_loss = static_cast<float>(robust_loss(kBehindCameraSigmas * kBehindCameraSigmas, threshold));
    problem_.free_index = s_.window.free_index.data();
    problem_.free_frames = s_.window.free_frames;
    problem_.groups = s_.window.group.data();
    problem_.group_count = s_.window.groups;
    problem_.observations = s_.window.observations.data();
    problem_.poses = s_.poses.data();
    for (std::size_t k = 0; k < static_cast<std::size_t>(s_.window.frames); ++k) {
      s_.poses[k] = kernel_pose(s_.window.T_cam_anchor[k]);
    }
  }

  BundleSummary run() {
    BundleSummary summary;
    double damping = std::max(config_.initial_damping, kMinDamping);
    double cost = linearise(damping);
    summary.initial_cost = cost;
    while (summary.iterations < config_.max_iterations && !summary.converged) {
      ++summary.iterations;
      if (!solve_for_step()) {
        damping = std::min(kDampingUp * damping, kMaxDamping);
        linearise(damping);
        continue;
      }
      const double moved_cost = move();
      summary.converged = std::abs(cost - moved_cost) <= config_.relative_cost_tolerance * cost;
      const bool better = moved_cost < cost;
      if (better) {
        accept();
        cost = moved_cost;
      }
      damping = std::clamp(damping * (better ? kDampingDown : kDampingUp), kMinDamping, kMaxDamping);
      if (!summary.converged && summary.iterations < config_.max_iterations) {
        linearise(damping);
      }
    }
    summary.final_cost = cost;
    return summary;
  }

  /// Marginal covariance of free pose `place`, left perturbation of T_cam_anchor.
  Matrix6d marginal_covariance(int place) {
    double damping = kMinDamping;
    linearise(damping);
    while (!factorise()) {
      damping *= kDampingUp;
      if (damping > kMaxDamping) {
        return Matrix6d::Identity() / kPriorInformation;
      }
      linearise(damping);
    }
    Matrix6d covariance;
    for (int c = 0; c < kPoseSize; ++c) {
      std::fill_n(s_.step.begin(), size_, 0.0);
      step(kPoseSize * place + c) = 1.0;
      cholesky_kernel().solve(s_.system.data(), size_, size_, s_.step.data());
      for (int r = 0; r < kPoseSize; ++r) {
        covariance(r, c) = step(kPoseSize * place + r);
      }
    }
    return 0.5 * covariance_factor(config_.robust_threshold_sigmas) * (covariance + covariance.transpose());
  }

 private:
  /// Builds the reduced camera system; returns the cost.
  double linearise(double damping) {
    problem_.points = s_.window.current.data();
    const double cost = bundle_kernel().eliminate_points(problem_, static_cast<float>(damping), s_.factors.data(),
                                                         s_.frames.data(), s_.blocks.data());
    for (int i = 0; i < problem_.free_frames; ++i) {
      for (int j = 0; j <= i; ++j) {
        subtract_block(i, j);
      }
      add_frame(i, damping);
    }
    for (std::size_t k = 1; k < turns_.size(); ++k) {
      add_turn(k);
    }
    return cost + turn_cost(s_.window.T_cam_anchor);
  }

  double& entry(int row, int column) {
    return s_
        .system[static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(column)];
  }
  double& step(int row) { return s_.step[static_cast<std::size_t>(row)]; }

  void subtract_block(int i, int j) {
    const int index = block_index(i, j);
    const BlockSums& block = s_.blocks[static_cast<std::size_t>(index)];
    for (int r = 0; r < kPoseSize; ++r) {
      for (int c = 0; c < kPoseSize; ++c) {
        entry(kPoseSize * i + r, kPoseSize * j + c) = -sum_lanes(block.entry[kPoseSize * r + c]);
      }
    }
  }

  void add_frame(int i, double damping) {
    const FrameSums& frame = s_.frames[static_cast<std::size_t>(i)];
    int k = 0;
    for (int r = 0; r < kPoseSize; ++r) {
      for (int c = 0; c <= r; ++c) {
        const double value = sum_lanes(frame.hessian[k++]);
        entry(kPoseSize * i + r, kPoseSize * i + c) += r == c ? (1.0 + damping) * value + kPriorInformation : value;
      }
      step(kPoseSize * i + r) = -sum_lanes(frame.reduced_gradient[r]);
    }
  }

  [[nodiscard]] Eigen::Vector3d turn(std::span<const Se3> T_cam_anchor, std::size_t k) const {
    return turn_residual(turns_[k], T_cam_anchor[k - 1].rotation, T_cam_anchor[k].rotation);
  }

  [[nodiscard]] double turn_cost(std::span<const Se3> T_cam_anchor) const {
    double cost = 0.0;
    for (std::size_t k = 1; k < turns_.size(); ++k) {
      cost += 0.5 * robust_loss(turn(T_cam_anchor, k).squaredNorm(), kTurnThreshold);
    }
    return cost;
  }

  /// Adds the prior on the rotation from frame k - 1 to frame k to their rows of the system.
  void add_turn(std::size_t k) {
    const TurnPrior& prior = turns_[k];
    const int before = s_.window.free_index[k - 1];
    const int now = s_.window.free_index[k];
    const Eigen::Vector3d off = turn(s_.window.T_cam_anchor, k);
    const double weight = robust_weight(off.squaredNorm(), kTurnThreshold) * prior.inverse_sigma_rad;
    const double information = weight * prior.inverse_sigma_rad;
    const Eigen::Vector3d pull_now = weight * off;
    const Eigen::Vector3d pull_before = prior.R_before_now * pull_now;
    for (int r = 0; r < 3; ++r) {
      if (before >= 0) {
        entry(kPoseSize * before + r, kPoseSize * before + r) += information;
        step(kPoseSize * before + r) -= pull_before[r];
      }
      if (now >= 0) {
        entry(kPoseSize * now + r, kPoseSize * now + r) += information;
        step(kPoseSize * now + r) += pull_now[r];
      }
      for (int c = 0; before >= 0 && now >= 0 && c < 3; ++c) {
        // Lower triangle: the later of the two frames has the higher row.
        entry(kPoseSize * now + r, kPoseSize * before + c) -= information * prior.R_before_now(c, r);
      }
    }
  }

  bool factorise() { return cholesky_kernel().factorise(s_.system.data(), size_, size_); }

  bool solve_for_step() {
    if (!factorise()) {
      return false;
    }
    cholesky_kernel().solve(s_.system.data(), size_, size_, s_.step.data());
    return true;
  }

  /// Applies the step to the moved poses and points; returns their cost.
  double move() {
    for (std::size_t k = 0; k < static_cast<std::size_t>(s_.window.frames); ++k) {
      const int place = s_.window.free_index[k];
      s_.moved_T_cam_anchor[k] = s_.window.T_cam_anchor[k];
      if (place >= 0) {
        const Vector6d xi(&step(kPoseSize * place));
        s_.moved_T_cam_anchor[k] = left_update(s_.window.T_cam_anchor[k], xi).orthonormalised();
      }
      s_.moved_poses[k] = kernel_pose(s_.moved_T_cam_anchor[k]);
    }
    std::transform(s_.step.begin(), s_.step.begin() + size_, s_.kernel_step.begin(),
                   [](double value) { return static_cast<float>(value); });
    return turn_cost(s_.moved_T_cam_anchor) + bundle_kernel().move_points(problem_, s_.factors.data(),
                                                                          s_.kernel_step.data(), s_.moved_poses.data(),
                                                                          s_.moved_points.data());
  }

  void accept() {
    std::swap(s_.window.T_cam_anchor, s_.moved_T_cam_anchor);
    std::swap(s_.poses, s_.moved_poses);
    std::swap(s_.window.current, s_.moved_points);
    problem_.poses = s_.poses.data();
  }

  const FixedBundleConfig& config_;
  std::span<const TurnPrior> turns_;
  FixedBundleStorage& s_;
  int size_;  ///< Of the camera system.
  KernelProblem problem_;
};

}  // namespace

Status FixedBundleConfig::validate() const {
  if (max_frames < 2 || max_frames > kMaxWindowFrames) {
    return out_of_range("max_frames", "[2, 32]", max_frames);
  }
  if (max_points < 1 || max_points > 20000) {
    return out_of_range("max_points", "[1, 20000]", max_points);
  }
  if (max_iterations < 1 || max_iterations > 1000) {
    return out_of_range("max_iterations", "[1, 1000]", max_iterations);
  }
  if (!(robust_threshold_sigmas >= 0.1 && robust_threshold_sigmas <= 100.0)) {
    return out_of_range("robust_threshold_sigmas", "[0.1, 100]", robust_threshold_sigmas);
  }
  if (!(initial_damping >= 0.0 && initial_damping <= 1.0)) {
    return out_of_range("initial_damping", "[0, 1]", initial_damping);
  }
  if (!(relative_cost_tolerance >= 0.0 && relative_cost_tolerance < 1.0)) {
    return out_of_range("relative_cost_tolerance", "[0, 1)", relative_cost_tolerance);
  }
  return {};
}

std::size_t FixedBundleAdjuster::required_bytes(const FixedBundleConfig& config) {
  return measure_bytes([&config](Arena& arena) {
    (void)arena.take<FixedBundleStorage>(1);
    (void)carve(config, arena);
  });
}

Result<FixedBundleAdjuster> FixedBundleAdjuster::create(const FixedBundleConfig& config, Arena& arena) {
  if (Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const std::span<FixedBundleStorage> storage = arena.take<FixedBundleStorage>(1);
  const FixedBundleStorage carved = carve(config, arena);
  if (storage.empty() || arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "working memory does not hold the bundle adjuster: it needs " +
                                          std::to_string(required_bytes(config)) + " bytes");
  }
  storage.front() = carved;
  return FixedBundleAdjuster(config, storage.front());
}

Result<BundleSummary> FixedBundleAdjuster::refine(BundleWindow& window) {
  if (Status valid = check_window(window); !valid) {
    return Unexpected(valid.error());
  }
  const std::size_t frames = window.T_body_cam.size();
  const int points = PackedWindow::count_points(window);
  if (frames > static_cast<std::size_t>(config_.max_frames) || points > config_.max_points) {
    return fail(ErrorCode::kCapacity,
                "window of " + std::to_string(frames) + " frames and " + std::to_string(points) +
                    " points exceeds refinement.max_frames = " + std::to_string(config_.max_frames) +
                    ", refinement.max_points = " + std::to_string(config_.max_points));
  }
  if (points == 0 || (~window.fixed_frames & frame_mask(frames)) == 0) {
    BundleSummary nothing_to_do;
    nothing_to_do.converged = true;
    return nothing_to_do;
  }
  PackedWindow& packed = storage_->window;
  packed.pack(window);
  Refinement refinement(config_, window, *storage_);
  BundleSummary summary = refinement.run();
  if (summary.final_cost < summary.initial_cost) {
    packed.unpack(window);
  }
  const int newest_place = packed.free_index[frames - 1];
  if (newest_place >= 0) {
    // A perturbation xi of T_cam_anchor equals one of -adjoint(T_body_cam) xi of T_body_cam.
    const Matrix6d carry = adjoint(window.T_body_cam.back());
    summary.newest_covariance = carry * refinement.marginal_covariance(newest_place) * carry.transpose();
  }
  return summary;
}

}  // namespace kinetrace::refinement
