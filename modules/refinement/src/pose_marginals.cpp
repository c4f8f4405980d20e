#include "pose_marginals.hpp"

#include <array>
#include <map>

#include <Eigen/Cholesky>

namespace kinetrace::refinement {
namespace {

constexpr Eigen::Index kPose = 6;
constexpr Eigen::Index kPoint = 3;
constexpr double kWeakPrior = 1e-6;

using PoseByPoint = Eigen::Matrix<double, kPose, kPoint>;

/// J^T J by blocks.
class Information {
 public:
  Information(std::size_t points, std::size_t poses)
      : points_(points, kWeakPrior * Eigen::Matrix3d::Identity()),
        mixed_(points),
        poses_(kWeakPrior * Eigen::MatrixXd::Identity(kPose * static_cast<Eigen::Index>(poses),
                                                      kPose * static_cast<Eigen::Index>(poses))) {}

  /// One row of J: its entries, by ascending column.
  void add_row(const int* columns, const double* values, std::size_t count) {
    const auto point_columns = kPoint * static_cast<Eigen::Index>(points_.size());
    std::size_t of_point = 0;
    while (of_point < count && columns[of_point] < point_columns) {
      ++of_point;
    }
    for (std::size_t i = of_point; i < count; ++i) {
      for (std::size_t j = of_point; j <= i; ++j) {
        poses_(columns[i] - point_columns, columns[j] - point_columns) += values[i] * values[j];
      }
    }
    if (of_point == 0) {
      return;
    }
    const auto point = static_cast<std::size_t>(columns[0] / kPoint);
    const Eigen::Map<const Eigen::Vector3d> by_point(values);
    points_[point] += by_point * by_point.transpose();
    for (std::size_t i = of_point; i < count; ++i) {
      const Eigen::Index at = columns[i] - point_columns;
      PoseByPoint& block = mixed_[point].try_emplace(at / kPose, PoseByPoint::Zero()).first->second;
      block.row(at % kPose) += values[i] * by_point.transpose();
    }
  }

  /// Block of the poses; its lower triangle.
  Eigen::MatrixXd& without_points() {
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const Eigen::Matrix3d covariance = points_[p].inverse();
      for (const auto& [i, by_i] : mixed_[p]) {
        const PoseByPoint weighted = by_i * covariance;
        for (const auto& [j, by_j] : mixed_[p]) {
          if (j > i) {
            break;
          }
          poses_.block<kPose, kPose>(kPose * i, kPose * j) -= weighted * by_j.transpose();
        }
      }
    }
    return poses_;
  }

 private:
  std::vector<Eigen::Matrix3d> points_;
  std::vector<std::map<Eigen::Index, PoseByPoint>> mixed_;  ///< By point, then pose.
  Eigen::MatrixXd poses_;
};

}  // namespace

std::vector<Matrix6d> marginal_pose_covariances(const ceres::CRSMatrix& jacobian, std::size_t points,
                                                std::size_t poses) {
  Information information(points, poses);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const auto begin = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row)]);
    const auto end = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row) + 1]);
    information.add_row(jacobian.cols.data() + begin, jacobian.values.data() + begin, end - begin);
  }
  Eigen::MatrixXd& reduced = information.without_points();
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(reduced);
  // Blocks of L^-T L^-1: columns of L^-1 are zero above the diagonal.
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(reduced.rows(), reduced.cols());
  factor.matrixL().solveInPlace(inverse);
  std::vector<Matrix6d> covariances;
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(poses); ++k) {
    const auto columns = inverse.block(kPose * k, kPose * k, inverse.rows() - kPose * k, kPose);
    covariances.push_back(columns.transpose() * columns);
  }
  return covariances;
}

}  // namespace kinetrace::refinement
