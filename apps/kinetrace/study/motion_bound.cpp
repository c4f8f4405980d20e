#include "study/motion_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "kinetrace/core/body_velocity.hpp"

namespace kinetrace::app {
namespace {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr double kMaxSpeed_mps = 50.0;
constexpr double kMaxTurn_radps = 10.0;
constexpr double kMinStep_s = 1e-4;

Vector6d weights(double rotation, double translation) {
  Vector6d w;
  w << Eigen::Vector3d::Constant(1.0 / rotation), Eigen::Vector3d::Constant(1.0 / translation);
  return w;
}

/// Derivative of a point in the object's frame by the perturbation of the pose.
Matrix36d lever(const Eigen::Vector3d& position_m) {
  Matrix36d d;
  d << -skew(position_m), Eigen::Matrix3d::Identity();
  return d;
}

/// Fisher information of a point's position in the object from one view.
Eigen::Matrix3d point_information(const SeenBody::View& view, const Eigen::Vector3d& position_m,
                                  const StereoGeometry& geometry, const PixelNoise& noise) {
  const Eigen::Vector3d p = view.T_cam_obj * position_m;
  const double depth2 = p.z() * p.z();
  Eigen::Matrix3d by_point;
  by_point << geometry.fx_px / p.z(), 0.0, -geometry.fx_px * p.x() / depth2,  //
      0.0, geometry.fy_px / p.z(), -geometry.fy_px * p.y() / depth2,          //
      0.0, 0.0, -geometry.fx_px * geometry.baseline_m / depth2;
  const Eigen::Vector3d sigma_px(noise.position_px, noise.position_px, noise.disparity_px);
  const Eigen::Matrix3d weighted = sigma_px.cwiseInverse().asDiagonal() * by_point * view.T_cam_obj.rotation;
  return weighted.transpose() * weighted;
}

/// Normal equations of the poses, six rows a view.
class Information {
 public:
  explicit Information(std::size_t views)
      : matrix_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * views), static_cast<Eigen::Index>(6 * views))) {}

  auto block(std::size_t k, std::size_t l) {
    return matrix_.block<6, 6>(static_cast<Eigen::Index>(6 * k), static_cast<Eigen::Index>(6 * l));
  }

  void add_point(const SeenBody& body, const SeenBody::Point& point, const StereoGeometry& geometry,
                 const PixelNoise& noise) {
    const Matrix36d d = lever(point.position_m);
    std::vector<Eigen::Matrix3d> seen;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const std::size_t k : point.views) {
      seen.push_back(point_information(body.views[k], point.position_m, geometry, noise));
      sum += seen.back();
    }
    const Eigen::Matrix3d inverse = sum.inverse();
    for (std::size_t a = 0; a < seen.size(); ++a) {
      block(point.views[a], point.views[a]) += d.transpose() * seen[a] * d;
      for (std::size_t b = 0; b < seen.size(); ++b) {
        block(point.views[a], point.views[b]) -= d.transpose() * seen[a] * inverse * seen[b] * d;
      }
    }
  }

  void add_prior(const SeenBody& body, const MotionPrior& prior) {
    // Derivative of the velocity between views, in the object's axes, by the perturbations of both.
    struct Velocity {
      double step_s;
      Matrix6d by_from;
      Matrix6d by_to;
    };
    std::vector<Velocity> velocities;
    const Matrix6d slow = weights(kMaxTurn_radps, kMaxSpeed_mps).asDiagonal();
    // Of the first velocity; the others follow by their changes. True poses are upright: y is down.
    Matrix6d along_ground = slow;
    along_ground(4, 4) = 1.0 / std::min(kMaxSpeed_mps, prior.vertical_speed_mps);
    for (std::size_t k = 0; k + 1 < body.views.size(); ++k) {
      const SeenBody::View& from = body.views[k];
      const SeenBody::View& to = body.views[k + 1];
      const double step_s = std::max(1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns), kMinStep_s);
      const Matrix6d back = adjoint(to.T_world_obj.inverse() * from.T_world_obj);
      velocities.push_back({step_s, -back / step_s, Matrix6d::Identity() / step_s});
      add_factor(k == 0 ? along_ground : slow, {{k, velocities.back().by_from}, {k + 1, velocities.back().by_to}});
    }
    for (std::size_t k = 0; k + 1 < velocities.size(); ++k) {
      const Velocity& before = velocities[k];
      const Velocity& after = velocities[k + 1];
      const Eigen::Matrix3d& upright = body.views[k + 1].T_world_obj.rotation;
      add_factor(prior.root_information(upright.col(1), upright, 0.5 * (before.step_s + after.step_s)),
                 {{k, -before.by_from}, {k + 1, after.by_from - before.by_to}, {k + 2, after.by_to}});
    }
  }

  /// Covariance of all perturbations; those of the first view are zero.
  Eigen::MatrixXd covariance() const {
    const Eigen::Index free = matrix_.rows() - 6;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(matrix_.rows(), matrix_.cols());
    covariance.bottomRightCorner(free, free) =
        matrix_.bottomRightCorner(free, free).llt().solve(Eigen::MatrixXd::Identity(free, free));
    return covariance;
  }

 private:
  struct Term {
    std::size_t view;
    Matrix6d jacobian;
  };
  void add_factor(const Matrix6d& weight, const std::vector<Term>& terms) {
    for (const Term& a : terms) {
      for (const Term& b : terms) {
        block(a.view, b.view) += (weight * a.jacobian).transpose() * weight * b.jacobian;
      }
    }
  }

  Eigen::MatrixXd matrix_;
};

}  // namespace

std::vector<PoseBound> pose_bounds(const SeenBody& body, const StereoGeometry& geometry, const PixelNoise& noise,
                                   const MotionPrior& prior) {
  std::vector<PoseBound> bounds(body.views.size());
  if (body.views.size() < 2) {
    return bounds;
  }
  Information information(body.views.size());
  for (const SeenBody::Point& point : body.points) {
    information.add_point(body, point, geometry, noise);
  }
  information.add_prior(body, prior);
  const Eigen::MatrixXd covariance = information.covariance();
  const auto pair = [&](std::size_t k, std::size_t l) -> Matrix6d {
    return covariance.block<6, 6>(static_cast<Eigen::Index>(6 * k), static_cast<Eigen::Index>(6 * l));
  };
  // Covariance of the centre with the mean of all centres; the centre minus the mean has the variance C_kk - 2 C_km +
  // C_mm.
  const Matrix36d to_center = lever(body.center_m);
  const double share = 1.0 / static_cast<double>(body.views.size());
  std::vector<double> with_mean(body.views.size(), 0.0);
  double of_mean = 0.0;
  for (std::size_t k = 0; k < body.views.size(); ++k) {
    for (std::size_t l = 0; l < body.views.size(); ++l) {
      with_mean[k] += share * (to_center * pair(k, l) * to_center.transpose()).trace();
    }
    of_mean += share * with_mean[k];
  }
  for (std::size_t k = 0; k < body.views.size(); ++k) {
    const double own = (to_center * pair(k, k) * to_center.transpose()).trace();
    bounds[k].place_m = std::sqrt(std::max(own - 2.0 * with_mean[k] + of_mean, 0.0));
    if (k > 0) {
      const Matrix6d motion = pair(k, k) - pair(k, k - 1) - pair(k - 1, k) + pair(k - 1, k - 1);
      bounds[k].motion_m = std::sqrt(motion.bottomRightCorner<3, 3>().trace());
      bounds[k].motion_deg = std::sqrt(motion.topLeftCorner<3, 3>().trace()) * 180.0 / std::numbers::pi;
    }
  }
  return bounds;
}

}  // namespace kinetrace::app
