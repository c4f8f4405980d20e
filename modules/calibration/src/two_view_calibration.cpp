#include "two_view_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetrace::calibration {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

constexpr int kRows = 8;    // u, v of left and right, before and now.
constexpr int kMotion = 6;  // Left perturbation of T_now_before.
constexpr int kShared = kMotion + RigMeasurement::kSize;
constexpr int kFreedom = kRows - 3;  // Of what is left of a point.
constexpr double kMinDepth_m = 0.3;
constexpr double kMinDisparity_px = 0.5;
constexpr int kMaxIterations = 12;
// Steps below this fraction of a pixel change nothing.
constexpr double kConverged_rad = 2e-6;
// A point whose squared residual is this often the expected one weighs half.
constexpr double kRobust = 2.0;

// Standard deviations in pixels, from rendered recordings. Finding a corner in an image at all, following it to a later
// frame, matching it with the right image: what is new in each frame, and what stays with the point.
constexpr double kCorner_px = 0.05;
constexpr double kFollow_px = 0.12;
constexpr double kMatch_px = 0.08;
constexpr double kMatchOfPoint_px = 0.12;
// Weak knowledge that keeps the system solvable where points tell nothing at all: nobody mounts cameras like that.
constexpr double kLoose_rad = 0.2;
constexpr double kLooseShift_rad = 0.004;
constexpr double kLooseChange_rad = 0.01;

using RowVector = Eigen::Matrix<double, kRows, 1>;
using Whitening = Eigen::Matrix<double, kRows, kRows>;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

Whitening make_whitening() {
  const auto squared = [](double x) { return x * x; };
  Whitening covariance = Whitening::Zero();
  // Of the columns, then of the rows: left before, right before, left now, right now. A patch that is placed wrongly in
  // the left image is looked for in the right one.
  for (const int axis : {0, 1}) {
    const int left_before = axis;
    const int right_before = axis + 2;
    const int left = axis + 4;
    const int right = axis + 6;
    const double placed = squared(kCorner_px);
    const double followed = placed + squared(kFollow_px);
    covariance(left_before, left_before) = placed;
    covariance(left_before, right_before) = covariance(right_before, left_before) = placed;
    covariance(right_before, right_before) = placed + squared(kMatch_px) + squared(kMatchOfPoint_px);
    covariance(left, left) = followed;
    covariance(left, right) = covariance(right, left) = followed;
    covariance(right, right) = followed + squared(kMatch_px) + squared(kMatchOfPoint_px);
    covariance(right_before, right) = covariance(right, right_before) = squared(kMatchOfPoint_px);
  }
  const Whitening lower = covariance.llt().matrixL();
  return lower.inverse();
}

/// One stereo frame's view of a point in the left camera's frame.
struct StereoView {
  StereoView(const StereoGeometry& geometry, const RigCorrection& correction)
      : g(geometry), R_right_left(so3_exp(-correction.turn_rad)) {
    const Vector3 direction(1.0, correction.baseline_rad.x(), correction.baseline_rad.y());
    centre_m = g.baseline_m * direction.normalized();
    shift_px = {correction.shift_rad * g.fx_px, 0.0};
  }

  struct Linearised {
    Eigen::Vector4d predicted_px;
    Eigen::Matrix<double, 4, 3> by_point;
    Eigen::Matrix<double, 2, RigCorrection::kSize> right_by_correction;
  };
  [[nodiscard]] Eigen::Matrix<double, 2, 3> by_point(const Vector3& p) const {
    Eigen::Matrix<double, 2, 3> J;
    J << g.fx_px / p.z(), 0.0, -g.fx_px * p.x() / (p.z() * p.z()), 0.0, g.fy_px / p.z(),
        -g.fy_px * p.y() / (p.z() * p.z());
    return J;
  }
  [[nodiscard]] Eigen::Vector2d pixel(const Vector3& p) const {
    return {g.fx_px * p.x() / p.z() + g.cx_px, g.fy_px * p.y() / p.z() + g.cy_px};
  }
  [[nodiscard]] Linearised linearise(const Vector3& p_left) const {
    const Vector3 p_right = R_right_left * (p_left - centre_m);
    const Eigen::Matrix<double, 2, 3> J_right = by_point(p_right);
    Linearised out;
    out.predicted_px << pixel(p_left), pixel(p_right) - shift_px;
    out.by_point << by_point(p_left), J_right * R_right_left;
    out.right_by_correction << J_right * skew(p_right), -g.baseline_m * J_right * R_right_left.rightCols<2>(),
        Eigen::Vector2d(-g.fx_px, 0.0);
    return out;
  }

  StereoGeometry g;
  Matrix3 R_right_left;
  Vector3 centre_m;
  Eigen::Vector2d shift_px;
};

/// Unknowns that all points share.
struct Shared {
  Se3 T_now_before;
  RigMeasurement::Vector rig;  ///< The correction now, and its change.

  [[nodiscard]] RigCorrection now() const { return RigCorrection::from(rig.head<RigCorrection::kSize>()); }
  [[nodiscard]] RigCorrection before() const {
    return RigCorrection::from(rig.head<RigCorrection::kSize>() - rig.tail<RigCorrection::kSize>());
  }
};

struct NormalEquations {
  SharedMatrix hessian = SharedMatrix::Zero();
  SharedVector gradient = SharedVector::Zero();
  double weight = 0.0;
  double weighted_chi2 = 0.0;
  int agreeing = 0;
};

struct PointBlock {
  Eigen::Matrix<double, kRows, 3> by_point;
  Eigen::Matrix<double, kRows, kShared> by_shared;
  RowVector residual;
};

class TwoViewSystem {
 public:
  TwoViewSystem(const StereoGeometry& geometry, const Shared& shared)
      : shared_(shared), before_(geometry, shared.before()), now_(geometry, shared.now()) {}

  /// Where stereo and both frames see the point best, by two Gauss-Newton steps from its place by stereo.
  void add(const TwoViewPoint& point, const Whitening& whitening, NormalEquations& sums) const {
    constexpr int kSteps = 2;
    Vector3 p = triangulate(point);
    for (int i = 0; i < kSteps; ++i) {
      if (!visible(p)) {
        return;
      }
      const auto [residual, by_point] = point_part(point, p, whitening);
      p += (by_point.transpose() * by_point).ldlt().solve(by_point.transpose() * residual);
    }
    if (visible(p)) {
      eliminate(block(point, p, whitening), sums);
    }
  }

 private:
  [[nodiscard]] Vector3 triangulate(const TwoViewPoint& point) const {
    const StereoGeometry& g = before_.g;
    const Vector3 ray((static_cast<double>(point.right_before_px.x()) + before_.shift_px.x() - g.cx_px) / g.fx_px,
                      (static_cast<double>(point.right_before_px.y()) - g.cy_px) / g.fy_px, 1.0);
    const Eigen::Vector2d right = before_.pixel(before_.R_right_left.transpose() * ray);
    const double disparity_px = std::max(static_cast<double>(point.left_before_px.x()) - right.x(), kMinDisparity_px);
    return g.triangulate(static_cast<double>(point.left_before_px.x()), static_cast<double>(point.left_before_px.y()),
                         disparity_px);
  }
  [[nodiscard]] bool visible(const Vector3& p) const {
    return p.allFinite() && p.z() > kMinDepth_m && (shared_.T_now_before * p).z() > kMinDepth_m;
  }
  [[nodiscard]] static RowVector measured(const TwoViewPoint& point) {
    RowVector m;
    m << point.left_before_px.cast<double>(), point.right_before_px.cast<double>(), point.left_px.cast<double>(),
        point.right_px.cast<double>();
    return m;
  }

  struct PointPart {
    RowVector residual;
    Eigen::Matrix<double, kRows, 3> by_point;
  };
  [[nodiscard]] PointPart point_part(const TwoViewPoint& point, const Vector3& p, const Whitening& whitening) const {
    const StereoView::Linearised a = before_.linearise(p);
    const StereoView::Linearised b = now_.linearise(shared_.T_now_before * p);
    RowVector predicted;
    predicted << a.predicted_px, b.predicted_px;
    Eigen::Matrix<double, kRows, 3> by_point;
    by_point << a.by_point, b.by_point * shared_.T_now_before.rotation;
    return {whitening * (measured(point) - predicted), whitening * by_point};
  }
  [[nodiscard]] PointBlock block(const TwoViewPoint& point, const Vector3& p, const Whitening& whitening) const {
    const Vector3 p_now = shared_.T_now_before * p;
    const StereoView::Linearised a = before_.linearise(p);
    const StereoView::Linearised b = now_.linearise(p_now);
    constexpr int kRig = RigCorrection::kSize;
    Eigen::Matrix<double, kRows, kShared> J = Eigen::Matrix<double, kRows, kShared>::Zero();
    J.block<4, 3>(4, 0) = -b.by_point * skew(p_now);
    J.block<4, 3>(4, 3) = b.by_point;
    J.block<2, kRig>(2, kMotion) = a.right_by_correction;
    J.block<2, kRig>(2, kMotion + kRig) = -a.right_by_correction;
    J.block<2, kRig>(6, kMotion) = b.right_by_correction;
    const PointPart part = point_part(point, p, whitening);
    return {part.by_point, whitening * J, part.residual};
  }
  static void eliminate(const PointBlock& block, NormalEquations& sums) {
    const Matrix3 inverse = (block.by_point.transpose() * block.by_point).inverse();
    const Eigen::Matrix<double, kShared, 3> coupling = block.by_shared.transpose() * block.by_point;
    const Vector3 by_point = block.by_point.transpose() * block.residual;
    const double chi2 = block.residual.squaredNorm() - by_point.dot(inverse * by_point);
    if (!std::isfinite(chi2)) {
      return;
    }
    const double weight = 1.0 / (1.0 + std::max(chi2, 0.0) / (kRobust * kFreedom));
    const Eigen::Matrix<double, kShared, 3> reduced = coupling * inverse;
    sums.hessian.noalias() += weight * (block.by_shared.transpose() * block.by_shared - reduced * coupling.transpose());
    sums.gradient.noalias() += weight * (block.by_shared.transpose() * block.residual - reduced * by_point);
    sums.weight += weight;
    sums.weighted_chi2 += weight * chi2;
    sums.agreeing += weight > 0.5 ? 1 : 0;
  }

  const Shared& shared_;
  StereoView before_;
  StereoView now_;
};

NormalEquations linearise(const StereoGeometry& geometry, std::span<const TwoViewPoint> points, const Shared& shared,
                          const Whitening& whitening) {
  NormalEquations sums;
  const TwoViewSystem system(geometry, shared);
  for (const TwoViewPoint& point : points) {
    system.add(point, whitening, sums);
  }
  RigMeasurement::Vector loose_rad;
  loose_rad.head<RigCorrection::kSize>().setConstant(kLoose_rad);
  loose_rad.tail<RigCorrection::kSize>().setConstant(kLooseChange_rad);
  loose_rad[RigCorrection::kSize - 1] = kLooseShift_rad;
  const RigMeasurement::Vector weight = loose_rad.array().square().inverse();
  sums.hessian.diagonal().tail<RigMeasurement::kSize>() += weight;
  sums.gradient.tail<RigMeasurement::kSize>() -= weight.cwiseProduct(shared.rig);
  return sums;
}

}  // namespace

RigMeasurement calibrate_two_views(const StereoGeometry& geometry, std::span<const TwoViewPoint> points,
                                   const Se3& T_now_before, const RigMeasurement::Vector& start) {
  const Whitening whitening = make_whitening();
  Shared shared{T_now_before, start};
  RigMeasurement out;
  NormalEquations sums;
  for (int i = 0; i < kMaxIterations; ++i) {
    sums = linearise(geometry, points, shared, whitening);
    const SharedVector step = sums.hessian.ldlt().solve(sums.gradient);
    if (!step.allFinite()) {
      return out;
    }
    shared.T_now_before = left_update(shared.T_now_before, step.head<kMotion>());
    shared.rig += step.tail<RigMeasurement::kSize>();
    if (step.cwiseAbs().maxCoeff() < kConverged_rad) {
      break;
    }
  }
  out.value = shared.rig;
  out.points = sums.agreeing;
  out.misfit = std::sqrt(sums.weighted_chi2 / std::max(kFreedom * sums.weight, 1.0));
  const SharedMatrix inverse = sums.hessian.ldlt().solve(SharedMatrix::Identity());
  out.covariance = inverse.bottomRightCorner<RigMeasurement::kSize, RigMeasurement::kSize>() *
                   std::max(1.0, out.misfit * out.misfit);
  out.valid = out.covariance.allFinite() && out.value.allFinite();
  return out;
}

}  // namespace kinetrace::calibration
