#include "marginal_covariance.hpp"

#include <array>
#include <bit>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "reprojection_jacobian.hpp"
#include "robust_loss.hpp"
#include "turn_residual.hpp"
#include "window_check.hpp"

namespace kinetrace::refinement {
namespace {

constexpr double kPriorInformation = 1e-6;
constexpr double kMinRelativePointInformation = 1e-9;
using Matrix63d = Eigen::Matrix<double, 6, 3>;

struct Coupling {
  Eigen::Index place;
  Matrix63d w;
};

/// Information of the rotation prior on the poses of frames k - 1 and k.
void add_turn(const BundleWindow& window, std::size_t k, const std::vector<Eigen::Index>& place,
              Eigen::MatrixXd& information) {
  const TurnPrior& prior = window.turns[k];
  const Eigen::Vector3d off =
      turn_residual(prior, window.T_body_cam[k - 1].rotation.transpose(), window.T_body_cam[k].rotation.transpose());
  const double weight =
      robust_weight(off.squaredNorm(), kTurnThreshold) * prior.inverse_sigma_rad * prior.inverse_sigma_rad;
  const std::array<std::pair<Eigen::Index, Eigen::Matrix3d>, 2> sides{
      {{place[k - 1], prior.R_before_now.transpose()}, {place[k], -Eigen::Matrix3d::Identity()}}};
  for (const auto& [row, d_row] : sides) {
    for (const auto& [column, d_column] : sides) {
      if (row >= 0 && column >= 0) {
        information.block<3, 3>(row, column) += weight * d_row.transpose() * d_column;
      }
    }
  }
}

}  // namespace

Matrix6d newest_marginal_covariance(const BundleWindow& window, double robust_threshold) {
  const std::size_t frames = window.T_body_cam.size();
  std::vector<Eigen::Index> place(frames, -1);
  Eigen::Index size = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    if ((window.fixed_frames >> k & 1U) == 0) {
      place[k] = size;
      size += 6;
    }
  }
  if (frames == 0 || place.back() < 0) {
    return Matrix6d::Zero();
  }
  Eigen::MatrixXd information = kPriorInformation * Eigen::MatrixXd::Identity(size, size);
  for (std::size_t p = 0; p < window.points.size(); ++p) {
    Eigen::Matrix3d point_information = Eigen::Matrix3d::Zero();
    std::vector<Coupling> couplings;
    for (std::uint32_t rest = window.points[p].frames & frame_mask(frames); rest != 0; rest &= rest - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(rest));
      const Se3 T_cam_body = window.T_body_cam[k].inverse();
      const Eigen::Vector3d p_cam = T_cam_body * window.points[p].position_m;
      const ReprojectionJacobian r = reprojection_jacobian(window.geometry, window.observation(p, k), p_cam);
      const double weight = robust_weight(r.residual.squaredNorm(), robust_threshold);
      const Eigen::Matrix3d j_point = r.d_point * T_cam_body.rotation;
      point_information += weight * j_point.transpose() * j_point;
      if (place[k] >= 0) {
        const Eigen::Matrix<double, 3, 6> j_pose = r.d_point * pose_jacobian(p_cam);
        information.block<6, 6>(place[k], place[k]) += weight * j_pose.transpose() * j_pose;
        couplings.push_back({place[k], weight * j_pose.transpose() * j_point});
      }
    }
    point_information.diagonal() *= 1.0 + kMinRelativePointInformation;
    point_information.diagonal().array() += 1e-30;
    const Eigen::Matrix3d point_covariance = point_information.inverse();
    for (const Coupling& a : couplings) {
      for (const Coupling& b : couplings) {
        information.block<6, 6>(a.place, b.place) -= a.w * point_covariance * b.w.transpose();
      }
    }
  }
  for (std::size_t k = 1; k < window.turns.size(); ++k) {
    add_turn(window, k, place, information);
  }
  const Eigen::MatrixXd covariance = information.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
  const Matrix6d carry = adjoint(window.T_body_cam.back());
  return covariance_factor(robust_threshold) * carry * covariance.block<6, 6>(place.back(), place.back()) *
         carry.transpose();
}

}  // namespace kinetrace::refinement
