#include "box_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

#include "kinetrace/core/box3.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr double kMaskEdgeSigma_px = 1.5;  // Of a mask's edge, standard deviation.
constexpr double kShapeSigma_m = 0.10;     // Deviation of a body's outline from its shape model.
constexpr double kSurfaceSigma_m = 0.06;   // Unevenness of its faces, outwards.
constexpr double kMeanRecess_m = 0.20;     // Mean depth of windows and other recesses behind a face.
constexpr double kPointsPerView = 5.0;     // Independent points that all points of a view count as.
constexpr double kCauchyScale = 3.0;       // Scale of Cauchy's loss, in standard deviations.
constexpr double kMinCornerDepth_m = 0.3;  // Minimum depth of a corner: nearer ones are far outside the image.
constexpr double kMinSize_m = 0.2;
constexpr double kCenterPrior_m = 4.0;  // About the start; regularises the system.
constexpr double kYawPrior_rad = 1.5;
constexpr double kMaxStep_m = 1.0;
constexpr double kMaxTurn_rad = 0.3;
// Mean squared residual of a body that fits: depths behind faces are exponential, outlines differ from their shape
// models.
constexpr double kUsualMisfit = 5.0;
constexpr double kParameters = 3.0;  // Determined by measurements alone; sizes have a prior.

// Points of outlines, in half lengths, half heights (down) and half widths of the box. A car's is symmetric: its front
// may not be known.
constexpr int kSaloonOutlinePoints = 20;
const std::array<Eigen::Vector3d, 8> kBoxOutline{{{-0.97, 1, -0.95},
                                                  {0.97, 1, -0.95},
                                                  {-0.97, 1, 0.95},
                                                  {0.97, 1, 0.95},
                                                  {-0.95, -1, -0.92},
                                                  {0.95, -1, -0.92},
                                                  {-0.95, -1, 0.92},
                                                  {0.95, -1, 0.92}}};
const std::array<Eigen::Vector3d, kSaloonOutlinePoints> kSaloonOutline{
    {{-0.62, 1, -0.95},   {0.62, 1, -0.95},   {-0.62, 1, 0.95},   {0.62, 1, 0.95},     // Wheels.
     {-1, 0.6, -0.78},    {1, 0.6, -0.78},    {-1, 0.6, 0.78},    {1, 0.6, 0.78},      // Bumpers.
     {-0.88, 0.4, -1},    {0.88, 0.4, -1},    {-0.88, 0.4, 1},    {0.88, 0.4, 1},      // Flanks.
     {-0.95, -0.2, -0.8}, {0.95, -0.2, -0.8}, {-0.95, -0.2, 0.8}, {0.95, -0.2, 0.8},   // Bonnet and boot.
     {-0.46, -1, -0.75},  {0.46, -1, -0.75},  {-0.46, -1, 0.75},  {0.46, -1, 0.75}}};  // Roof.

std::span<const Eigen::Vector3d> outline_of(BodyShape shape) {
  return shape == BodyShape::kSaloon ? std::span<const Eigen::Vector3d>(kSaloonOutline)
                                     : std::span<const Eigen::Vector3d>(kBoxOutline);
}

/// Log density of the normal distributions of the dimensions, up to a constant.
double log_density(const KindOfObject& kind, const Eigen::Vector3d& size_m) {
  const Eigen::Vector3d sigma_m = kind.sigma_m.cast<double>();
  const Eigen::Vector3d z = (size_m - kind.mean_m.cast<double>()).cwiseQuotient(sigma_m);
  return std::log(double{kind.share}) - 0.5 * z.squaredNorm() - std::log(sigma_m.prod());
}

class Problem {
 public:
  Problem(const BoxEvidence& evidence, const BoxState& start) : evidence_(evidence), start_(start), state_(start) {}

  /// `with_cost`: also computes the cost for result(); its logarithms take time.
  void linearise(bool with_cost) {
    with_cost_ = with_cost;
    A_ = upright_axes(evidence_.down, state_.yaw_rad);
    H_.setZero();
    g_.setZero();
    cost_ = 0.0;
    misfit_ = 0.0;
    residuals_ = 0.0;
    add_size_prior();
    add_regularisation();
    for (const BoxView& view : evidence_.views) {
      if (view.quality > 0.0) {
        add_edges(view);
        add_points(view);
      }
    }
    add_ground();
    add_heading();
  }

  void step() {
    Matrix7d damped = H_;
    damped.diagonal() *= 1.001;
    Vector7d delta = -damped.ldlt().solve(g_);
    const double size = std::max({delta.head<3>().norm() / kMaxStep_m, std::abs(delta[3]) / kMaxTurn_rad,
                                  delta.tail<3>().norm() / kMaxStep_m, 1.0});
    delta /= size;
    state_.center_m += delta.head<3>();
    state_.yaw_rad = std::remainder(state_.yaw_rad + delta[3], 2.0 * std::numbers::pi);
    state_.size_m = (state_.size_m + delta.tail<3>()).cwiseMax(kMinSize_m);
  }

  /// A misfit scales the covariance up.
  [[nodiscard]] BoxFit result() const {
    const double surplus = std::max(residuals_ - kParameters, 1.0);
    const double misfit = std::max(1.0, misfit_ / (kUsualMisfit * surplus));
    return {state_, cost_, misfit, misfit * H_.inverse()};
  }

 private:
  void add(double residual, const Vector7d& J, double weight = 1.0) {
    const double over = residual * residual / (kCauchyScale * kCauchyScale);
    const double robust = weight / (1.0 + over);
    H_ += robust * J * J.transpose();
    g_ += robust * residual * J;
    if (with_cost_) {
      const double loss = weight * kCauchyScale * kCauchyScale * std::log1p(over);
      cost_ += loss;
      misfit_ += loss;
      residuals_ += weight;
    }
  }

  void add_size_prior() {
    double total = 0.0;
    double max_density = -std::numeric_limits<double>::infinity();
    for (const KindOfObject& kind : evidence_.kinds) {
      if (const double density = log_density(kind, state_.size_m); density > max_density) {
        max_density = density;
        shape_ = kind.shape;
      }
    }
    for (const KindOfObject& kind : evidence_.kinds) {
      total += std::exp(log_density(kind, state_.size_m) - max_density);
    }
    for (const KindOfObject& kind : evidence_.kinds) {
      const double responsibility = std::exp(log_density(kind, state_.size_m) - max_density) / total;
      const Eigen::Vector3d information = responsibility * kind.sigma_m.cast<double>().cwiseAbs2().cwiseInverse();
      H_.diagonal().tail<3>() += information;
      g_.tail<3>() += information.cwiseProduct(state_.size_m - kind.mean_m.cast<double>());
    }
    cost_ -= 2.0 * (max_density + std::log(total));
  }

  void add_regularisation() {
    const double of_center = 1.0 / (kCenterPrior_m * kCenterPrior_m);
    H_.diagonal().head<3>().array() += of_center;
    g_.head<3>() += of_center * (state_.center_m - start_.center_m);
    H_(3, 3) += 1.0 / (kYawPrior_rad * kYawPrior_rad);
  }

  void add_ground() {
    const Ground& ground = evidence_.ground;
    if (!ground.known) {
      return;
    }
    const double off_m = ground.down.dot(state_.center_m) - ground.height_m + 0.5 * state_.size_m.y();
    Vector7d J = Vector7d::Zero();
    J.head<3>() = ground.down;
    J[5] = 0.5;
    add(off_m / ground.sigma_m, J / ground.sigma_m);
  }

  void add_heading() {
    if (!evidence_.heading) {
      return;
    }
    const Heading& heading = *evidence_.heading;
    Vector7d J = Vector7d::Zero();
    J[3] = 1.0 / heading.sigma_rad;
    const double off_rad = std::remainder(state_.yaw_rad - heading.yaw_rad, 2.0 * std::numbers::pi);
    // Not robust: a box turned by 180 degrees is no outlier.
    H_ += J * J.transpose();
    g_ += off_rad / heading.sigma_rad * J;
    cost_ += off_rad * off_rad / (heading.sigma_rad * heading.sigma_rad);
  }

  /// The outermost point of the projected outline on one side.
  struct Extreme {
    double at_px = 0.0;
    Eigen::Vector3d k = Eigen::Vector3d::Zero();
    Eigen::Vector3d p_cam = Eigen::Vector3d::Zero();
  };

  /// As MaskEdges: lowest and highest u, lowest and highest v.
  [[nodiscard]] std::array<Extreme, 4> extremes(const Se3& T_cam_obj) const {
    std::array<Extreme, 4> found;
    bool is_first = true;
    for (const Eigen::Vector3d& k : outline_of(shape_)) {
      Eigen::Vector3d p_cam = T_cam_obj * (state_.center_m + 0.5 * (A_ * k.cwiseProduct(state_.size_m)));
      p_cam.z() = std::max(p_cam.z(), kMinCornerDepth_m);
      const Eigen::Vector3d uv = evidence_.geometry.project(p_cam);
      for (std::size_t side = 0; side < found.size(); ++side) {
        const double at_px = uv[static_cast<Eigen::Index>(side / 2)];
        if (is_first || (side % 2 == 0 ? at_px < found[side].at_px : at_px > found[side].at_px)) {
          found[side] = {at_px, k, p_cam};
        }
      }
      is_first = false;
    }
    return found;
  }

  void add_edges(const BoxView& view) {
    const Se3 T_cam_obj = view.T_obj_cam.inverse();
    const std::array<Extreme, 4> outermost = extremes(T_cam_obj);
    for (std::size_t side = 0; side < outermost.size(); ++side) {
      add_edge(view, T_cam_obj.rotation, side, outermost[side]);
    }
  }

  void add_edge(const BoxView& view, const Eigen::Matrix3d& R_cam_obj, std::size_t side, const Extreme& extreme) {
    const double off_px = extreme.at_px - view.edges.at_px[side];
    const bool is_beyond = side % 2 == 0 ? off_px < 0.0 : off_px > 0.0;
    const double beyond_sigma_px = is_beyond ? view.edges.beyond_sigma_px[side] : 0.0;
    if (std::isinf(beyond_sigma_px)) {
      return;
    }
    const Eigen::Index axis = side < 2 ? 0 : 1;
    const double per_m = (axis == 0 ? evidence_.geometry.fx_px : evidence_.geometry.fy_px) / extreme.p_cam.z();
    Eigen::RowVector3d J_cam = Eigen::RowVector3d::Zero();
    J_cam[axis] = per_m;
    J_cam[2] = -per_m * extreme.p_cam[axis] / extreme.p_cam.z();
    const Eigen::RowVector3d J_obj = J_cam * R_cam_obj;
    const Eigen::Vector3d arm = 0.5 * extreme.k.cwiseProduct(state_.size_m);
    Vector7d J;
    J.head<3>() = J_obj.transpose();
    J[3] = J_obj.dot(arm.z() * A_.col(0) - arm.x() * A_.col(2));
    J.tail<3>() = 0.5 * extreme.k.cwiseProduct((J_obj * A_).transpose());
    const double sigma_px = std::hypot(kMaskEdgeSigma_px, kShapeSigma_m * per_m, beyond_sigma_px);
    add(off_px / sigma_px, J / sigma_px);
  }

  /// Points lie on visible faces, some behind them, none in front.
  void add_points(const BoxView& view) {
    const Eigen::Vector3d camera = A_.transpose() * (view.T_obj_cam.translation - state_.center_m);
    // The points' error along the ray, across the faces of each axis.
    const Eigen::Vector3d sigma_m = view.depth_sigma_m * camera.normalized().cwiseAbs();
    const double weight = std::min(1.0, kPointsPerView / std::max(static_cast<double>(view.point_count), 1.0));
    for (std::size_t i = 0; i < view.point_count; ++i) {
      const Eigen::Vector3d q = A_.transpose() * (view.points_m[i].cast<double>() - state_.center_m);
      if (!add_outside(q, sigma_m, weight)) {
        add_inside(q, camera, sigma_m, weight);
      }
    }
  }

  /// Residuals to the faces that `q` is in front of; false if it is inside the box.
  bool add_outside(const Eigen::Vector3d& q, const Eigen::Vector3d& sigma_m, double weight) {
    bool is_outside = false;
    for (int axis = 0; axis < 3; ++axis) {
      const double side = q[axis] > 0.0 ? 1.0 : -1.0;
      const double depth_m = 0.5 * state_.size_m[axis] - side * q[axis];
      if (depth_m < 0.0) {
        is_outside = true;
        add_face(depth_m, axis, side, q, std::hypot(kSurfaceSigma_m, sigma_m[axis]), weight);
      }
    }
    return is_outside;
  }

  /// Residual to the nearest of the faces visible from `camera`; both in the box's axes.
  void add_inside(const Eigen::Vector3d& q, const Eigen::Vector3d& camera, const Eigen::Vector3d& sigma_m,
                  double weight) {
    double nearest_m = std::numeric_limits<double>::infinity();
    int nearest = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const double half_m = 0.5 * state_.size_m[axis];
      const double behind_m = half_m - std::copysign(1.0, camera[axis]) * q[axis];
      if (std::abs(camera[axis]) > half_m && behind_m < nearest_m) {
        nearest_m = behind_m;
        nearest = axis;
      }
    }
    if (nearest >= 0) {
      add_face(nearest_m, nearest, std::copysign(1.0, camera[nearest]), q, kMeanRecess_m + sigma_m[nearest], weight);
    }
  }

  /// A point `depth_m` behind the face of `axis` on its positive or negative `side`.
  void add_face(double depth_m, int axis, double side, const Eigen::Vector3d& q, double sigma_m, double weight) {
    Vector7d J = Vector7d::Zero();
    J.head<3>() = side * A_.col(axis);
    J[3] = axis == 0 ? side * q.z() : axis == 2 ? -side * q.x() : 0.0;
    J[4 + axis] = 0.5;
    add(depth_m / sigma_m, J / sigma_m, weight);
  }

  const BoxEvidence& evidence_;
  BoxState start_;
  BoxState state_;
  Eigen::Matrix3d A_ = Eigen::Matrix3d::Identity();  ///< Axes of the box in the object's frame.
  BodyShape shape_ = BodyShape::kBox;
  Matrix7d H_ = Matrix7d::Zero();
  Vector7d g_ = Vector7d::Zero();
  double cost_ = 0.0;
  double misfit_ = 0.0;     ///< Part of the cost due to measurements.
  double residuals_ = 0.0;  ///< Number of residuals, by their weights.
  bool with_cost_ = false;
};

}  // namespace

BoxFit fit_box(const BoxEvidence& evidence, const BoxState& start, int iterations) noexcept {
  Problem problem(evidence, start);
  for (int i = 0; i < iterations; ++i) {
    problem.linearise(false);
    problem.step();
  }
  problem.linearise(true);
  return problem.result();
}

}  // namespace kinetrace::trajectory
