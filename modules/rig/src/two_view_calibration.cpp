#include "two_view_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Householder>
#include <Eigen/LU>

namespace kinetrace::rig {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

constexpr int kRows = 8;    // u, v of left and right, before and now.
constexpr int kMotion = 6;  // Left perturbation of T_now_before.
constexpr int kShared = kMotion + RigMeasurement::kSize;
constexpr int kFreedom = kRows - 3;  // Of a point's rows, after its elimination.
constexpr double kMinDepth_m = 0.3;
constexpr double kMinDisparity_px = 0.5;
constexpr int kMaxIterations = 12;
// Smaller steps are far below a pixel.
constexpr double kConverged_rad = 1e-5;
// A point whose squared residual is this many times its expectation gets weight one half.
constexpr double kRobust = 2.0;

// Standard deviations in pixels, from rendered recordings: locating a corner, following it to a later frame, and
// matching it with the right image, the part that is new in each frame and the part that stays with the point.
constexpr double kCorner_px = 0.05;
constexpr double kFollow_px = 0.12;
constexpr double kMatch_px = 0.08;
constexpr double kMatchOfPoint_px = 0.12;
// Weak priors that keep the system solvable where the points hold no information; far beyond the tolerances of mounts.
constexpr double kLoose_rad = 0.2;
constexpr double kLooseShift_rad = 0.0002;
constexpr double kLooseFocal = 0.03;
constexpr double kHeldFocal = 1e-6;
constexpr double kNothingKnown = 1.0;
constexpr double kLooseChange_rad = 0.01;
// A focal length follows the temperature: a change of 1e-5 within a window would take a kelvin per second.
constexpr double kFocalChange = 1e-5;

using RowVector = Eigen::Matrix<double, kRows, 1>;
/// Rows of one axis: left before, right before, left now, right now.
constexpr int kAxisRows = kRows / 2;
using Whitening = Eigen::Matrix<double, kAxisRows, kAxisRows>;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

// The right match starts from the left patch and inherits its error. Columns and rows are independent.
Whitening make_whitening() {
  const auto squared = [](double x) { return x * x; };
  const double placed = squared(kCorner_px);
  const double followed = placed + squared(kFollow_px);
  const double matched = squared(kMatch_px) + squared(kMatchOfPoint_px);
  const double of_point = squared(kMatchOfPoint_px);
  Whitening covariance;
  covariance << placed, placed, 0.0, 0.0,       //
      placed, placed + matched, 0.0, of_point,  //
      0.0, 0.0, followed, followed,             //
      0.0, of_point, followed, followed + matched;
  const Whitening lower = covariance.llt().matrixL();
  return lower.inverse();
}

/// Reorders rows from images (u and v in turn) to axes, and whitens them.
template <int kColumns>
Eigen::Matrix<double, kRows, kColumns> whitened(const Whitening& whitening,
                                                const Eigen::Matrix<double, kRows, kColumns>& rows) {
  Eigen::Matrix<double, kRows, kColumns> out;
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < kAxisRows; ++i) {
      Eigen::Matrix<double, 1, kColumns> sum = whitening(i, i) * rows.row(2 * i + axis);
      for (int k = 0; k < i; ++k) {
        sum += whitening(i, k) * rows.row(2 * k + axis);
      }
      out.row(kAxisRows * axis + i) = sum;
    }
  }
  return out;
}

/// Projection of a point in the left camera's frame into both images of a frame.
struct StereoView {
  StereoView(const StereoGeometry& geometry, const RigCorrection& correction)
      : g(geometry), R_right_left(so3_exp(-correction.turn_rad)), per_focal(1.0 / (1.0 + correction.focal)) {
    g.fx_px *= 1.0 + correction.focal;
    g.fy_px *= 1.0 + correction.focal;
    const Vector3 direction(1.0, correction.baseline_rad.x(), correction.baseline_rad.y());
    centre_m = g.baseline_m * direction.normalized();
    shift_px = {correction.shift_rad * g.fx_px, 0.0};
  }

  struct Linearised {
    Eigen::Vector4d predicted_px;
    Eigen::Matrix<double, 4, 3> by_point;
    Eigen::Matrix<double, 4, RigCorrection::kSize> by_correction;
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
    out.by_correction.setZero();
    out.by_correction.bottomLeftCorner<2, RigCorrection::kFocal>() << J_right * skew(p_right),
        -g.baseline_m * J_right * R_right_left.rightCols<2>(), Eigen::Vector2d(-g.fx_px, 0.0);
    out.by_correction.col(RigCorrection::kFocal) =
        per_focal * (out.predicted_px - Eigen::Vector4d(g.cx_px, g.cy_px, g.cx_px, g.cy_px));
    return out;
  }

  StereoGeometry g;
  Matrix3 R_right_left;
  Vector3 centre_m;
  double per_focal;
  Eigen::Vector2d shift_px;
};

/// Unknowns that all points share.
struct Shared {
  Se3 T_now_before;
  RigMeasurement::Vector rig;  ///< The present correction, and its change.

  [[nodiscard]] RigCorrection now() const { return RigCorrection::from(rig.head<RigCorrection::kSize>()); }
  [[nodiscard]] RigCorrection before() const {
    return RigCorrection::from(rig.head<RigCorrection::kSize>() - rig.tail<RigCorrection::kSize>());
  }
};

struct NormalEquations {
  SharedMatrix hessian = SharedMatrix::Zero();  ///< The lower triangle.
  SharedVector gradient = SharedVector::Zero();
  double weight = 0.0;
  double weighted_chi2 = 0.0;
  int agreeing = 0;
};

/// Derivatives by the shared unknowns; the last column is the residual.
using PointRows = Eigen::Matrix<double, kRows, kShared + 1>;

/// Householder reflection: afterwards only the first `kColumn + 1` rows depend on the point's first `kColumn + 1`
/// coordinates.
template <int kColumn>
void eliminate_point_column(Eigen::Matrix<double, kRows, 3>& by_point, PointRows& rows) {
  constexpr int kBelow = kRows - kColumn;
  Eigen::Matrix<double, kBelow - 1, 1> essential;
  double tau = 0.0;
  double beta = 0.0;
  by_point.col(kColumn).template tail<kBelow>().makeHouseholder(essential, tau, beta);
  Eigen::Matrix<double, 1, kShared + 1> workspace;
  rows.template bottomRows<kBelow>().applyHouseholderOnTheLeft(essential, tau, workspace.data());
  if constexpr (kColumn < 2) {
    by_point.template bottomRightCorner<kBelow, 2 - kColumn>().applyHouseholderOnTheLeft(essential, tau,
                                                                                         workspace.data());
  }
}

class TwoViewSystem {
 public:
  TwoViewSystem(const StereoGeometry& geometry, const Shared& shared)
      : shared_(shared), before_(geometry, shared.before()), now_(geometry, shared.now()) {}

  /// Adds a point, placed by two Gauss-Newton steps over both frames from its stereo position.
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
      eliminate(point, p, whitening, sums);
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
    return {whitened<1>(whitening, measured(point) - predicted), whitened<3>(whitening, by_point)};
  }
  /// Rows independent of the point hold all its information on the shared unknowns (Demmel et al., "Square root bundle
  /// adjustment for large-scale reconstruction", 2021).
  void eliminate(const TwoViewPoint& point, const Vector3& p, const Whitening& whitening, NormalEquations& sums) const {
    PointPart part = point_part(point, p, whitening);
    PointRows rows;
    rows << whitened<kShared>(whitening, by_shared(p)), part.residual;
    eliminate_point_column<0>(part.by_point, rows);
    eliminate_point_column<1>(part.by_point, rows);
    eliminate_point_column<2>(part.by_point, rows);
    const auto free = rows.bottomRows<kFreedom>();
    const double chi2 = free.col(kShared).squaredNorm();
    if (!std::isfinite(chi2)) {
      return;
    }
    const double weight = 1.0 / (1.0 + chi2 / (kRobust * kFreedom));
    for (int i = 0; i < kShared; ++i) {
      const Eigen::Matrix<double, kFreedom, 1> column = weight * free.col(i);
      for (int k = 0; k <= i; ++k) {
        sums.hessian(i, k) += column.dot(free.col(k));
      }
      sums.gradient[i] += column.dot(free.col(kShared));
    }
    sums.weight += weight;
    sums.weighted_chi2 += weight * chi2;
    sums.agreeing += weight > 0.5 ? 1 : 0;
  }
  [[nodiscard]] Eigen::Matrix<double, kRows, kShared> by_shared(const Vector3& p) const {
    const Vector3 p_now = shared_.T_now_before * p;
    const StereoView::Linearised a = before_.linearise(p);
    const StereoView::Linearised b = now_.linearise(p_now);
    constexpr int kRig = RigCorrection::kSize;
    Eigen::Matrix<double, kRows, kShared> J = Eigen::Matrix<double, kRows, kShared>::Zero();
    J.block<4, 3>(4, 0) = -b.by_point * skew(p_now);
    J.block<4, 3>(4, 3) = b.by_point;
    J.block<4, kRig>(0, kMotion) = a.by_correction;
    J.block<4, kRig>(0, kMotion + kRig) = -a.by_correction;
    J.block<4, kRig>(4, kMotion) = b.by_correction;
    return J;
  }

  const Shared& shared_;
  StereoView before_;
  StereoView now_;
};

/// Weak prior of the measurement.
struct WeakPrior {
  WeakPrior(const RigMeasurement::Vector& start, bool focal_shown) {
    expected[RigCorrection::kFocal] = start[RigCorrection::kFocal];
    sigma.head<RigCorrection::kSize>().setConstant(kLoose_rad);
    sigma.tail<RigCorrection::kSize>().setConstant(kLooseChange_rad);
    sigma[RigCorrection::kShift] = kLooseShift_rad;
    sigma[RigCorrection::kFocal] = focal_shown ? kLooseFocal : kHeldFocal;
    sigma[RigCorrection::kSize + RigCorrection::kFocal] = kFocalChange;
  }

  RigMeasurement::Vector expected = RigMeasurement::Vector::Zero();
  RigMeasurement::Vector sigma;
};

NormalEquations linearise(const StereoGeometry& geometry, std::span<const TwoViewPoint> points, const Shared& shared,
                          const Whitening& whitening, const WeakPrior& prior) {
  NormalEquations sums;
  const TwoViewSystem system(geometry, shared);
  for (const TwoViewPoint& point : points) {
    system.add(point, whitening, sums);
  }
  const RigMeasurement::Vector weight = prior.sigma.array().square().inverse();
  sums.hessian.diagonal().tail<RigMeasurement::kSize>() += weight;
  sums.gradient.tail<RigMeasurement::kSize>() -= weight.cwiseProduct(shared.rig - prior.expected);
  return sums;
}

}  // namespace

RigMeasurement calibrate_two_views(const StereoGeometry& geometry, std::span<const TwoViewPoint> points,
                                   const Se3& T_now_before, const RigMeasurement::Vector& start, bool focal_shown) {
  const Whitening whitening = make_whitening();
  const WeakPrior prior(start, focal_shown);
  Shared shared{T_now_before, start};
  RigMeasurement out;
  NormalEquations sums;
  for (int i = 0; i < kMaxIterations; ++i) {
    sums = linearise(geometry, points, shared, whitening, prior);
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
  out.rms_ratio = std::sqrt(sums.weighted_chi2 / std::max(kFreedom * sums.weight, 1.0));
  const SharedMatrix inverse = sums.hessian.ldlt().solve(SharedMatrix::Identity());
  out.covariance = inverse.bottomRightCorner<RigMeasurement::kSize, RigMeasurement::kSize>() *
                   std::max(1.0, out.rms_ratio * out.rms_ratio);
  if (!focal_shown) {
    out.covariance(RigCorrection::kFocal, RigCorrection::kFocal) = kNothingKnown;
  }
  out.valid = out.covariance.allFinite() && out.value.allFinite();
  return out;
}

}  // namespace kinetrace::rig
