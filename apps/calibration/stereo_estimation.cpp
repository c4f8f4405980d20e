#include "stereo_estimation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <thread>

#include <Eigen/Cholesky>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include "initial_guess.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "reprojection_cost.hpp"

namespace kinetrace::calibration {
namespace {

using Camera = std::array<double, kCameraParameters>;
using Perturbation = std::array<double, 6>;

constexpr std::size_t kMinViews = 3;
constexpr std::size_t kMinCorners = 6;

Camera parameters_of(const hal::CameraModel& model) {
  Camera camera{model.fx_px, model.fy_px, model.cx_px, model.cy_px};
  std::copy(model.distortion.begin(), model.distortion.end(), camera.begin() + 4);
  return camera;
}

hal::CameraModel model_with(hal::CameraModel model, const Camera& camera) {
  model.fx_px = camera[0];
  model.fy_px = camera[1];
  model.cx_px = camera[2];
  model.cy_px = camera[3];
  std::copy(camera.begin() + 4, camera.end(), model.distortion.begin());
  return model;
}

struct Measurement {
  std::size_t view = 0;  ///< Index within the problem.
  bool is_left = true;
  Corner corner;
};

// Free parameters in a stage of the solution.
struct Stage {
  bool principal_point = true;
  int coefficients = 0;
  double loss_px = 0.0;  ///< Scale of the robust loss; 0: least squares.
};

// The unknowns, and their measurements.
class StereoProblem {
 public:
  StereoProblem(const Target& target, std::span<const BoardView> views, const EstimationOptions& options)
      : target_(target), views_(views), options_(options) {}

  Status initialise() {
    std::vector<std::vector<Corner>> left;
    std::vector<std::vector<Corner>> right;
    for (const BoardView& view : views_) {
      left.push_back(view.left);
      right.push_back(view.right);
    }
    const auto left_camera = guess_camera(options_.lens, options_.width_px, options_.height_px, target_, left);
    const auto right_camera = guess_camera(options_.lens, options_.width_px, options_.height_px, target_, right);
    std::optional<StereoGuess> guess;
    if (left_camera && right_camera) {
      guess = guess_poses(*left_camera, *right_camera, target_, views_);
    }
    if (!guess) {
      return fail(ErrorCode::kBadCalibration,
                  "no view shows enough of the target in both images; check that --target describes it");
    }
    model_ = *left_camera;
    cameras_ = {parameters_of(*left_camera), parameters_of(*right_camera)};
    T_right_left_ = guess->T_right_left;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (guess->T_left_board[i] && views_[i].left.size() >= kMinCorners && views_[i].right.size() >= kMinCorners) {
        add_view(i, *guess->T_left_board[i]);
      }
    }
    return {};
  }

  [[nodiscard]] std::size_t view_count() const { return used_views_.size(); }

  void solve(const Stage& stage) {
    ceres::Problem problem;
    build(problem, stage);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-10;
    options.parameter_tolerance = 1e-10;
    options.num_threads =
        std::clamp(options_.threads, 1, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    fold_perturbations();
  }

  // Rejects outlier corners, and views that are worse than the others or keep too few corners.
  void reject_outliers() {
    const std::vector<Residual> all = residuals();
    std::vector<double> sizes;
    sizes.reserve(all.size());
    for (const Residual& residual : all) {
      sizes.push_back(residual.error_px.norm());
    }
    constexpr double kMinLimit_px = 0.2;
    const double limit_px = std::max(kMinLimit_px, sizes.empty() ? 0.0 : 6.0 * median(std::vector(sizes)));
    std::vector<std::array<Fit, 2>> fits(used_views_.size());
    for (std::size_t i = 0; i < measurements_.size(); ++i) {
      Fit& fit = fits[measurements_[i].view][measurements_[i].is_left ? 0 : 1];
      ++(sizes[i] <= limit_px ? fit.good : fit.bad);
    }
    std::vector<bool> is_bad;
    is_bad.reserve(fits.size());
    for (const auto& [left, right] : fits) {
      is_bad.push_back(left.is_bad() || right.is_bad());
    }
    std::vector<Measurement> kept;
    for (std::size_t i = 0; i < measurements_.size(); ++i) {
      if (is_bad[measurements_[i].view]) {
        continue;
      }
      sizes[i] <= limit_px ? kept.push_back(measurements_[i]) : static_cast<void>(++rejected_corners_);
    }
    measurements_ = std::move(kept);
    remove_views(is_bad);
  }

  [[nodiscard]] std::vector<Residual> residuals() const {
    std::vector<Residual> all;
    const hal::CameraModel left = model_with(model_, cameras_[0]);
    const hal::CameraModel right = model_with(model_, cameras_[1]);
    for (const Measurement& measured : measurements_) {
      const Eigen::Vector3d p_left = poses_[measured.view] * point(measured);
      const Eigen::Vector2d px = measured.is_left ? left.project(p_left) : right.project(T_right_left_ * p_left);
      all.push_back({used_views_[measured.view], measured.is_left, measured.corner.px, px - measured.corner.px});
    }
    return all;
  }

  [[nodiscard]] StereoEstimate estimate(const Stage& stage) {
    StereoEstimate estimate;
    estimate.rig.left = model_with(model_, cameras_[0]);
    estimate.rig.right = model_with(model_, cameras_[1]);
    estimate.rig.T_right_left = T_right_left_.orthonormalised();
    estimate.T_left_board = poses_;
    estimate.used_views = used_views_;
    estimate.rejected_views = views_.size() - used_views_.size();
    estimate.rejected_corners = rejected_corners_;
    estimate.residuals = residuals();
    add_errors(estimate);
    add_covariance(stage, estimate);
    return estimate;
  }

 private:
  // Corners of one image of a view.
  struct Fit {
    std::size_t good = 0;
    std::size_t bad = 0;
    [[nodiscard]] bool is_bad() const { return good < kMinCorners || 2 * bad > good; }
  };

  void add_view(std::size_t place, const Se3& T_left_board) {
    const std::size_t view = used_views_.size();
    used_views_.push_back(place);
    poses_.push_back(T_left_board);
    for (const Corner& corner : views_[place].left) {
      measurements_.push_back({view, true, corner});
    }
    for (const Corner& corner : views_[place].right) {
      measurements_.push_back({view, false, corner});
    }
  }

  void remove_views(const std::vector<bool>& is_bad) {
    std::vector<std::size_t> new_place(is_bad.size());
    std::vector<std::size_t> views;
    std::vector<Se3> poses;
    for (std::size_t i = 0; i < is_bad.size(); ++i) {
      new_place[i] = views.size();
      if (!is_bad[i]) {
        views.push_back(used_views_[i]);
        poses.push_back(poses_[i]);
      }
    }
    for (Measurement& measured : measurements_) {
      measured.view = new_place[measured.view];
    }
    used_views_ = std::move(views);
    poses_ = std::move(poses);
  }

  [[nodiscard]] const Eigen::Vector3d& point(const Measurement& measured) const {
    return target_.points_m[static_cast<std::size_t>(measured.corner.id)];
  }

  void build(ceres::Problem& problem, const Stage& stage) {
    moves_.assign(poses_.size(), Perturbation{});
    right_move_ = {};
    for (const Measurement& measured : measurements_) {
      ceres::LossFunction* loss = stage.loss_px > 0.0 ? new ceres::CauchyLoss(stage.loss_px) : nullptr;
      const ReprojectionCost cost{model_.lens, measured.corner.px, point(measured), &poses_[measured.view],
                                  measured.is_left ? nullptr : &T_right_left_};
      if (measured.is_left) {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<ReprojectionCost, 2, kCameraParameters, 6>(new ReprojectionCost(cost)),
            loss, cameras_[0].data(), moves_[measured.view].data());
      } else {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<ReprojectionCost, 2, kCameraParameters, 6, 6>(new ReprojectionCost(cost)),
            loss, cameras_[1].data(), moves_[measured.view].data(), right_move_.data());
      }
    }
    for (Camera& camera : cameras_) {
      constrain(problem, stage, camera);
    }
  }

  // The rational model's coefficients are hardly distinguishable: a weak prior keeps them at usual values.
  void constrain(ceres::Problem& problem, const Stage& stage, Camera& camera) const {
    std::vector<int> constant;
    if (!stage.principal_point) {
      constant = {2, 3};
    }
    for (int i = 4 + stage.coefficients; i < kCameraParameters; ++i) {
      constant.push_back(i);
    }
    if (!constant.empty()) {
      problem.SetManifold(camera.data(), new ceres::SubsetManifold(kCameraParameters, constant));
    }
    if (stage.coefficients > 5) {
      constexpr double kPriorWeight_px = 0.02;
      ceres::Matrix weights = ceres::Matrix::Zero(4, kCameraParameters);
      for (int i = 0; i < 4; ++i) {
        weights(i, 8 + i) = kPriorWeight_px;  // k3 to k6.
      }
      problem.AddResidualBlock(new ceres::NormalPrior(weights, ceres::Vector::Zero(kCameraParameters)), nullptr,
                               camera.data());
    }
  }

  void fold_perturbations() {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      poses_[i] = left_update(poses_[i], Vector6d(moves_[i].data())).orthonormalised();
      moves_[i] = {};
    }
    T_right_left_ = left_update(T_right_left_, Vector6d(right_move_.data())).orthonormalised();
    right_move_ = {};
  }

  void add_errors(StereoEstimate& estimate) const {
    std::array<double, 2> sums{};
    std::array<double, 2> counts{};
    for (const Residual& residual : estimate.residuals) {
      sums[residual.is_left ? 0 : 1] += residual.error_px.squaredNorm();
      counts[residual.is_left ? 0 : 1] += 1.0;
    }
    estimate.left_rms_px = std::sqrt(sums[0] / std::max(counts[0], 1.0));
    estimate.right_rms_px = std::sqrt(sums[1] / std::max(counts[1], 1.0));
  }

  // The inverse of the normal matrix, scaled by the residuals. Dense: a few hundred unknowns.
  void add_covariance(const Stage& stage, StereoEstimate& estimate) {
    ceres::Problem problem;
    build(problem, stage);
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = {cameras_[0].data(), cameras_[1].data(), right_move_.data()};
    for (Perturbation& move : moves_) {
      options.parameter_blocks.push_back(move.data());
    }
    double cost = 0.0;
    ceres::CRSMatrix jacobian;
    if (!problem.Evaluate(options, &cost, nullptr, nullptr, &jacobian)) {
      return;
    }
    const Eigen::MatrixXd normal = normal_matrix(jacobian);
    const auto freedom =
        std::max(static_cast<double>(2 * measurements_.size()) - static_cast<double>(normal.rows()), 1.0);
    estimate.sigma_px = std::sqrt(2.0 * cost / freedom);
    const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
    const int own = 2 * (4 + stage.coefficients) + 6;
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(normal.rows(), own);
    const Eigen::MatrixXd inverse = scaled.ldlt().solve(columns).topRows(own);
    const Eigen::MatrixXd covariance =
        estimate.sigma_px * estimate.sigma_px * (scale.head(own).asDiagonal() * inverse * scale.head(own).asDiagonal());
    scatter(covariance, stage.coefficients, estimate.covariance);
  }

  static Eigen::MatrixXd normal_matrix(const ceres::CRSMatrix& jacobian) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(jacobian.num_cols, jacobian.num_cols);
    for (std::size_t row = 0; row < static_cast<std::size_t>(jacobian.num_rows); ++row) {
      const auto begin = static_cast<std::size_t>(jacobian.rows[row]);
      const auto end = static_cast<std::size_t>(jacobian.rows[row + 1]);
      for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t j = begin; j < end; ++j) {
          normal(jacobian.cols[i], jacobian.cols[j]) += jacobian.values[i] * jacobian.values[j];
        }
      }
    }
    return normal;
  }

  // Spreads the covariance of the free parameters over all parameters.
  static void scatter(const Eigen::MatrixXd& covariance, int coefficients, ParameterMatrix& all) {
    std::vector<int> place;
    for (int camera = 0; camera < 2; ++camera) {
      for (int i = 0; i < 4 + coefficients; ++i) {
        place.push_back(camera * kCameraParameters + i);
      }
    }
    for (int i = 0; i < 6; ++i) {
      place.push_back(2 * kCameraParameters + i);
    }
    for (std::size_t i = 0; i < place.size(); ++i) {
      for (std::size_t j = 0; j < place.size(); ++j) {
        all(place[i], place[j]) = covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
  }

  const Target& target_;
  std::span<const BoardView> views_;
  EstimationOptions options_;
  hal::CameraModel model_;  ///< Kind of lens and size, the same for both.
  std::array<Camera, 2> cameras_{};
  Se3 T_right_left_;
  std::vector<std::size_t> used_views_;
  std::vector<Se3> poses_;
  std::vector<Measurement> measurements_;
  std::vector<Perturbation> moves_;
  Perturbation right_move_{};
  std::size_t rejected_corners_ = 0;
};

}  // namespace

std::string parameter_name(int index) {
  static constexpr std::array<const char*, kCameraParameters> kCamera{"fx", "fy", "cx", "cy", "d0", "d1",
                                                                      "d2", "d3", "d4", "d5", "d6", "d7"};
  static constexpr std::array<const char*, 6> kPose{"rx", "ry", "rz", "tx", "ty", "tz"};
  if (index >= 2 * kCameraParameters) {
    return kPose[static_cast<std::size_t>(index - 2 * kCameraParameters)];
  }
  return std::string(index < kCameraParameters ? "left_" : "right_") +
         kCamera[static_cast<std::size_t>(index % kCameraParameters)];
}

double StereoEstimate::relative_focal_sigma() const {
  const ParameterVector sigma = sigmas();
  return std::max({sigma(0) / rig.left.fx_px, sigma(1) / rig.left.fy_px, sigma(kCameraParameters) / rig.right.fx_px,
                   sigma(kCameraParameters + 1) / rig.right.fy_px});
}

Result<StereoEstimate> estimate_stereo(const Target& target, std::span<const BoardView> views,
                                       const EstimationOptions& options) {
  StereoProblem problem(target, views, options);
  if (const Status begun = problem.initialise(); !begun) {
    return Unexpected(begun.error());
  }
  const auto enough = [&problem] { return problem.view_count() >= kMinViews; };
  const Stage all{.coefficients = coefficient_count(options.lens)};
  if (enough()) {
    problem.solve({.principal_point = false, .coefficients = 1, .loss_px = 4.0});
    problem.solve({.coefficients = std::min(all.coefficients, 4), .loss_px = 2.0});
    problem.solve({.coefficients = all.coefficients, .loss_px = 0.5});
    problem.reject_outliers();
  }
  if (!enough()) {
    return fail(ErrorCode::kBadCalibration, "only " + std::to_string(problem.view_count()) +
                                                " views of the target agree with each other; check --target, and that "
                                                "both images are of the same moment");
  }
  problem.solve(all);
  StereoEstimate estimate = problem.estimate(all);
  estimate.rig.source = "calibration with a target";
  if (const Status valid = estimate.rig.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return estimate;
}

}  // namespace kinetrace::calibration
