#include "kinetrace/sfm/stereo_pose_estimator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

#include "kinetrace/core/stereo_reprojection.hpp"

namespace kinetrace::sfm {
namespace {

constexpr double kBehindCamera = 1e12;
constexpr double kMinDepth_m = 0.05;
constexpr double kTinyInformation = 1e-9;  // Keeps an unconstrained system solvable.
constexpr double kHuberSigmas = 2.8;       // 95 % quantile of the norm of three Gaussian residuals.
constexpr double kConverged = 1e-5;        // rad or m: far below measurement accuracy.
// Enough to rank hypotheses; all observations take part in the refinement.
constexpr std::size_t kScoredObservations = 160;

ReprojectionModel<double> model_of(const StereoGeometry& g) {
  return {g.fx_px, g.fy_px, g.cx_px, g.cy_px, g.fx_px * g.baseline_m};
}

/// Normal equations of one pose perturbation (rotation r, translation t), by blocks.
struct NormalEquations {
  Eigen::Matrix3d rr = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d tr = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d tt = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_r = Eigen::Vector3d::Zero();
  Eigen::Vector3d gradient_t = Eigen::Vector3d::Zero();
  int used = 0;

  [[nodiscard]] Matrix6d hessian() const {
    Matrix6d h;
    h << rr, tr.transpose(), tr, tt;
    return h;
  }
  [[nodiscard]] Vector6d gradient() const {
    Vector6d g;
    g << gradient_r, gradient_t;
    return g;
  }
};

void accumulate(const ReprojectionModel<double>& model, const Se3& pose, const PoseObservation& o, double sigma_px,
                double huber_sigmas, NormalEquations& normal) {
  const Eigen::Vector3d p = pose * o.p_body;
  if (p.z() < kMinDepth_m) {
    return;
  }
  const bool stereo = !std::isnan(o.u_right_px);
  StereoReprojection<double> s = stereo_reprojection<double>(model, p.x(), p.y(), p.z(), double{o.u_left_px},
                                                             double{o.v_px}, double{o.u_right_px});
  double du_right_dx = s.du_dx;
  if (!stereo) {  // A row of zeros has no effect.
    s.residual[2] = 0.0;
    s.du_right_dz = 0.0;
    du_right_dx = 0.0;
  }
  const double inverse_variance = 1.0 / (sigma_px * sigma_px * double{o.variance_ratio});
  const double norm = std::sqrt(inverse_variance * (s.residual[0] * s.residual[0] + s.residual[1] * s.residual[1] +
                                                    s.residual[2] * s.residual[2]));
  const double robust = norm <= huber_sigmas ? 1.0 : huber_sigmas / norm;
  const double weight = robust * inverse_variance;
  ++normal.used;

  // D = d residual / d p_cam; the perturbation enters by [ -skew(p), I ]. D^T D is built once and carried over.
  Eigen::Matrix3d d;
  d << s.du_dx, 0.0, s.du_left_dz, 0.0, s.dv_dy, s.dv_dz, du_right_dx, 0.0, s.du_right_dz;
  const Eigen::Matrix3d information = weight * d.transpose() * d;
  const Eigen::Vector3d gradient = weight * d.transpose() * Eigen::Map<const Eigen::Vector3d>(s.residual);
  const Eigen::Matrix3d turn = -skew(p);
  const Eigen::Matrix3d information_turn = information * turn;
  normal.tt += information;
  normal.tr += information_turn;
  normal.rr.noalias() += turn.transpose() * information_turn;
  normal.gradient_t += gradient;
  normal.gradient_r += p.cross(gradient);
}

void add_prior(const PosePrior& prior, const Se3& pose, NormalEquations& normal) {
  const Vector6d gradient = prior.information * left_difference(prior.T_cam_body, pose);
  normal.rr += prior.information.topLeftCorner<3, 3>();
  normal.tr += prior.information.bottomLeftCorner<3, 3>();
  normal.tt += prior.information.bottomRightCorner<3, 3>();
  normal.gradient_r += gradient.head<3>();
  normal.gradient_t += gradient.tail<3>();
}

double prior_cost(const PosePrior& prior, const Se3& pose) {
  const Vector6d off = left_difference(prior.T_cam_body, pose);
  return off.dot(prior.information * off);
}

/// One damped Gauss-Newton step: the perturbation, none when the system is singular.
std::optional<Vector6d> step(const NormalEquations& normal, double damping, Se3& pose) {
  Matrix6d h = normal.hessian();
  h.diagonal() *= 1.0 + damping;
  h.diagonal().array() += kTinyInformation;
  const Eigen::LDLT<Matrix6d> ldlt(h);
  const Vector6d xi = -ldlt.solve(normal.gradient());
  if (ldlt.info() != Eigen::Success || !xi.allFinite()) {
    return std::nullopt;
  }
  pose = left_update(pose, xi);
  return xi;
}

/// Small deterministic generator (numerical recipes' LCG): sampling needs spread, not secrecy.
class Sampler {
 public:
  explicit Sampler(std::uint32_t seed) : state_(seed * 747796405U + 2891336453U) {}
  std::size_t below(std::size_t n) {
    state_ = state_ * 1664525U + 1013904223U;
    return static_cast<std::size_t>((static_cast<std::uint64_t>(state_) * n) >> 32U);
  }

 private:
  std::uint32_t state_;
};

std::array<std::size_t, 3> sample_three(Sampler& sampler, std::size_t n) {
  std::array<std::size_t, 3> pick{sampler.below(n), sampler.below(n), sampler.below(n)};
  while (pick[1] == pick[0]) {
    pick[1] = sampler.below(n);
  }
  while (pick[2] == pick[0] || pick[2] == pick[1]) {
    pick[2] = sampler.below(n);
  }
  return pick;
}

/// Truncated cost (MSAC) over an even subset, with the number of inliers in it.
struct Score {
  double cost = std::numeric_limits<double>::infinity();
  std::size_t inliers = 0;
  std::size_t scored = 1;
};

Score score_pose(const StereoGeometry& geometry, const Se3& pose, std::span<const PoseObservation> observations,
                 double sigma_px, double gate2) {
  const std::size_t stride = std::max<std::size_t>(1, observations.size() / kScoredObservations);
  Score score{0.0, 0, 0};
  for (std::size_t i = 0; i < observations.size(); i += stride) {
    const double chi2 = reprojection_chi2(geometry, pose, observations[i], sigma_px);
    score.cost += std::min(chi2, gate2);
    score.inliers += chi2 < gate2 ? 1U : 0U;
    ++score.scored;
  }
  return score;
}

/// Samples needed to draw one clean triple with 99.9 % certainty.
int hypotheses_needed(const Score& best, int bound) {
  const double ratio = static_cast<double>(best.inliers) / static_cast<double>(best.scored);
  const double clean = ratio * ratio * ratio;
  if (clean > 0.999) {
    return 1;
  }
  if (clean < 1e-4) {
    return bound;
  }
  return std::min(bound, static_cast<int>(std::ceil(std::log(1e-3) / std::log(1.0 - clean))));
}

int classify(const StereoGeometry& geometry, const Se3& pose, std::span<const PoseObservation> observations,
             double sigma_px, double gate2, std::span<std::uint8_t> inlier) {
  int count = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    inlier[i] = reprojection_chi2(geometry, pose, observations[i], sigma_px) < gate2 ? 1 : 0;
    count += inlier[i];
  }
  return count;
}

/// Input of one call of estimate().
struct PoseProblem {
  const StereoGeometry& geometry;
  ReprojectionModel<double> model;
  std::span<const PoseObservation> observations;
  const PosePrior& prior;
  double sigma_px;
};

/// Pose that fits three observations, starting from `pose`; false when they are degenerate.
bool solve_three(const PoseProblem& problem, const std::array<std::size_t, 3>& pick, Se3& pose) {
  bool solved = true;
  for (int iteration = 0; iteration < 5 && solved; ++iteration) {
    NormalEquations normal;
    for (const std::size_t i : pick) {
      accumulate(problem.model, pose, problem.observations[i], problem.sigma_px,
                 std::numeric_limits<double>::infinity(), normal);
    }
    solved = normal.used == 3 && step(normal, 1e-3, pose).has_value();
  }
  return solved;
}

/// The best of the prior and of poses from samples of three (RANSAC), ranked by the observations of `voting`.
Se3 search_pose(const PoseProblem& voting, double gate2, int max_hypotheses) {
  const std::size_t n = voting.observations.size();
  Se3 best_pose = voting.prior.T_cam_body;
  Score best = score_pose(voting.geometry, best_pose, voting.observations, voting.sigma_px, gate2);
  Sampler sampler(static_cast<std::uint32_t>(n));
  int needed = hypotheses_needed(best, max_hypotheses);
  for (int hypothesis = 0; hypothesis < needed; ++hypothesis) {
    Se3 pose = best_pose;
    if (!solve_three(voting, sample_three(sampler, n), pose)) {
      continue;
    }
    Score score = score_pose(voting.geometry, pose, voting.observations, voting.sigma_px, gate2);
    score.cost += prior_cost(voting.prior, pose) * static_cast<double>(score.scored) / static_cast<double>(n);
    if (score.cost < best.cost) {
      best = score;
      best_pose = pose;
      needed = hypotheses_needed(best, max_hypotheses);
    }
  }
  return best_pose;
}

/// Robust Gauss-Newton over the inliers; none when their system is singular. Returns the last normal equations.
std::optional<NormalEquations> refine_pose(const PoseProblem& problem, std::span<const std::uint8_t> inlier,
                                           Se3& pose) {
  NormalEquations normal;
  for (int iteration = 0; iteration < 4; ++iteration) {
    normal = NormalEquations{};
    for (std::size_t i = 0; i < problem.observations.size(); ++i) {
      if (inlier[i] != 0) {
        accumulate(problem.model, pose, problem.observations[i], problem.sigma_px, kHuberSigmas, normal);
      }
    }
    add_prior(problem.prior, pose, normal);
    const std::optional<Vector6d> moved = step(normal, 1e-6, pose);
    if (!moved) {
      return std::nullopt;
    }
    if (moved->cwiseAbs().maxCoeff() < kConverged) {
      break;
    }
  }
  return normal;
}

Matrix6d covariance_of(const NormalEquations& normal) {
  Matrix6d h = normal.hessian();
  h.diagonal().array() += kTinyInformation;
  return h.ldlt().solve(Matrix6d::Identity());
}

}  // namespace

double reprojection_chi2(const StereoGeometry& geometry, const Se3& T_cam_body, const PoseObservation& o,
                         double sigma_px) {
  const Eigen::Vector3d p = T_cam_body * o.p_body;
  if (!(p.z() > kMinDepth_m)) {
    return kBehindCamera;
  }
  const Eigen::Vector3d uvr = geometry.project(p);
  const double du = uvr.x() - double{o.u_left_px};
  const double dv = uvr.y() - double{o.v_px};
  const double dr = std::isnan(o.u_right_px) ? 0.0 : uvr.z() - double{o.u_right_px};
  return (du * du + dv * dv + dr * dr) / (sigma_px * sigma_px * double{o.variance_ratio});
}

PoseEstimate StereoPoseEstimator::estimate(std::span<const PoseObservation> observations, const PosePrior& prior,
                                           double sigma_px, std::span<std::uint8_t> inlier,
                                           std::size_t consensus_size) const {
  PoseEstimate out;
  out.T_cam_body = prior.T_cam_body;
  std::fill(inlier.begin(), inlier.end(), std::uint8_t{0});
  const PoseProblem problem{geometry_, model_of(geometry_), observations, prior, sigma_px};
  PoseProblem voting = problem;
  voting.observations = observations.first(consensus_size);
  if (voting.observations.size() < 3) {
    return out;
  }
  const double gate2 = config_.gate_sigma * config_.gate_sigma;
  // Hypotheses are ranked with a wider gate, since their three points have errors; the final gate is the configured
  // one.
  const double search_gate2 = 4.0 * gate2;
  Se3 pose = search_pose(voting, search_gate2, config_.max_hypotheses);

  // Two rounds with a narrowing gate: the first removes the error of the three-point pose.
  std::optional<NormalEquations> last;
  for (const double round_gate2 : {search_gate2, gate2}) {
    if (classify(geometry_, pose, observations, sigma_px, round_gate2, inlier) < 3) {
      return out;
    }
    last = refine_pose(problem, inlier, pose);
    if (!last) {
      return out;
    }
  }
  pose = pose.orthonormalised();
  out.inliers = classify(geometry_, pose, observations, sigma_px, gate2, inlier);
  out.agreeing_consensus =
      static_cast<int>(std::count(inlier.begin(), inlier.begin() + static_cast<std::ptrdiff_t>(consensus_size), 1));
  out.valid = out.inliers >= 3 && pose.is_finite();
  if (out.valid) {
    out.T_cam_body = pose;
    out.covariance = covariance_of(*last);
  }
  return out;
}

}  // namespace kinetrace::sfm
