#include "kinetrace/trajectory/box_estimator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "box_fit.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr std::size_t kSides = 8;            // Views, one for each eighth of the circle around the object.
constexpr double kViewDecay_s = 3.0;         // Time after which a view counts 1/e of an equally good new one.
constexpr double kMinEdgeQuality = 0.5;      // Minimum factor of a view's quality per occluded edge.
constexpr float kMaxReprojection_px = 1.5F;  // Of a point; others are outliers.
constexpr int kFirstIterations = 6;
constexpr int kIterations = 2;
constexpr int kHypothesisIterations = 4;
constexpr std::uint32_t kUpdatesPerHypothesis = 2;  // Frames.
constexpr double kAcceptanceMargin = 6.0;           // Twice the log-likelihood ratio at which a new box is accepted.
constexpr double kAlternativeDecay = 0.95;          // Factor of a deviation per hypothesis tried.
constexpr std::size_t kYaws = 6;                    // Over half a circle.
constexpr double kBehindFace = 0.4;  // Distance of a body's centre behind its visible points, relative to its size.
constexpr double kShapeYawSigma_rad = 0.025;  // Error of yaw by shape: bodies are rounded and not quite symmetric.
constexpr double kTurnRateSigma_radps = 0.3;  // Of vehicles, standard deviation.
constexpr double kQuarter_rad = 0.5 * std::numbers::pi;

Eigen::Vector3d centroid(std::span<const BodyPoint> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const BodyPoint& point : points) {
    if (point.position_m.allFinite()) {
      sum += point.position_m.cast<double>();
      count += 1.0;
    }
  }
  return sum / std::max(count, 1.0);
}

}  // namespace

BoxEstimator::BoxEstimator(const SizeTable& sizes, const StereoGeometry& geometry, Arena& arena)
    : sizes_(sizes), geometry_(geometry), views_(arena.take<BoxView>(kSides)) {}

void BoxEstimator::reset() noexcept {
  forget_views();
  heading_.reset();
  sigma_ = Box3Sigma{};
  alternative_ = Box3Sigma{};
  timestamp_ns_ = 0;
  updates_ = 0;
  known_ = false;
}

void BoxEstimator::forget_views() noexcept {
  for (BoxView& view : views_) {
    view.quality = 0.0;
  }
}

/// Of the frames of one side, keeps the one in which the object is largest and least occluded, with decay over time.
void BoxEstimator::keep_view(const BoxFrame& frame) noexcept {
  const Eigen::Vector3d from =
      frame.T_obj_cam.translation - (known_ ? state_.center_m : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  const double side = upright_yaw(down_obj_, from) / (2.0 * std::numbers::pi) + 0.5;
  BoxView& view = views_[std::min(static_cast<std::size_t>(side * kSides), kSides - 1)];
  const std::array<double, 4>& at = frame.edges->at_px;
  double quality = std::min(at[1] - at[0], at[3] - at[2]);
  for (std::size_t edge = 0; edge < at.size(); ++edge) {
    const double extent_px = edge < 2 ? at[1] - at[0] : at[3] - at[2];
    quality *= std::max(1.0 - frame.edges->beyond_sigma_px[edge] / extent_px, kMinEdgeQuality);
  }
  const double age_s = 1e-9 * static_cast<double>(frame.timestamp_ns - view.timestamp_ns);
  if (quality <= view.quality * std::exp(-age_s / kViewDecay_s)) {
    return;
  }
  view.T_obj_cam = frame.T_obj_cam;
  view.edges = *frame.edges;
  view.quality = quality;
  view.timestamp_ns = frame.timestamp_ns;
  view.point_count = 0;
  const std::size_t stride = (frame.points.size() + BoxView::kMaxPoints - 1) / BoxView::kMaxPoints;
  double depth_m = 0.0;
  for (std::size_t i = 0; i < frame.points.size(); i += stride) {
    const BodyPoint& point = frame.points[i];
    if (point.position_m.allFinite() && point.reprojection_error_px < kMaxReprojection_px) {
      view.points_m[view.point_count++] = point.position_m;
      depth_m +=
          (frame.T_obj_cam.rotation.transpose() * (point.position_m.cast<double>() - frame.T_obj_cam.translation)).z();
    }
  }
  depth_m /= std::max<double>(static_cast<double>(view.point_count), 1.0);
  view.depth_sigma_m = geometry_.depth_sigma_m(depth_m, frame.disparity_sigma_px);
}

const KindOfObject& BoxEstimator::most_likely_kind(const BoxFrame& frame) const noexcept {
  const double depth_m = (frame.T_obj_cam.inverse() * centroid(frame.points)).z();
  const double height_m = (frame.edges->at_px[3] - frame.edges->at_px[2]) * depth_m / geometry_.fy_px;
  const auto log_probability = [&](const KindOfObject& kind) {
    const double z = (height_m - double{kind.mean_m.y()}) / (2.0 * double{kind.sigma_m.y()});
    return std::log(double{kind.share}) - 0.5 * z * z;
  };
  const std::span<const KindOfObject> kinds = sizes_.kinds_of(frame.class_id);
  return *std::max_element(kinds.begin(), kinds.end(), [&](const KindOfObject& a, const KindOfObject& b) {
    return log_probability(a) < log_probability(b);
  });
}

BoxState BoxEstimator::start_at(const BoxFrame& frame, double yaw_rad, const KindOfObject& kind) const noexcept {
  BoxState start{centroid(frame.points), yaw_rad, kind.mean_m.cast<double>()};
  Eigen::Vector3d ray = start.center_m - frame.T_obj_cam.translation;
  ray -= down_obj_ * down_obj_.dot(ray);
  if (ray.norm() > 1e-6) {
    ray.normalize();
    const Eigen::Matrix3d axes = upright_axes(down_obj_, yaw_rad);
    start.center_m +=
        kBehindFace *
        (std::abs(ray.dot(axes.col(0))) * start.size_m.x() + std::abs(ray.dot(axes.col(2))) * start.size_m.z()) * ray;
  }
  return start;
}

void BoxEstimator::begin(const BoxFrame& frame, const BoxEvidence& evidence) noexcept {
  known_ = true;
  alternative_ = Box3Sigma{};
  accept(fit_box(evidence, start_at(frame, heading_ ? heading_->yaw_rad : 0.0, most_likely_kind(frame)),
                 kFirstIterations));
  for (std::size_t i = 1; i < kYaws && !heading_; ++i) {
    const double yaw_rad = static_cast<double>(i) * std::numbers::pi / kYaws;
    test_hypothesis(evidence, start_at(frame, yaw_rad, most_likely_kind(frame)), kFirstIterations, 0.0);
  }
  for (const KindOfObject& kind : evidence.kinds) {
    test_hypothesis(evidence, start_at(frame, state_.yaw_rad, kind), kFirstIterations, 0.0);
  }
}

/// Accepts the box fitted from `start` if it is more probable.
void BoxEstimator::test_hypothesis(const BoxEvidence& evidence, const BoxState& start, int iterations,
                                   double margin) noexcept {
  const BoxFit fit = fit_box(evidence, start, iterations);
  const BoxState former = state_;
  const double cost_difference = (fit.cost - cost_) / fit.misfit;
  if (fit.cost < cost_ - margin) {
    accept(fit);
    record_alternative(former, -cost_difference);
  } else {
    record_alternative(fit.state, cost_difference);
  }
}

// One box is reported, so a rejected one counts by its deviation: the mean squared error of a mixture of the two. A
// few iterations from a new start do not always find the best alternative, so the largest recent deviation counts.
void BoxEstimator::record_alternative(const BoxState& other, double cost_difference) noexcept {
  const double root = std::sqrt(1.0 / (1.0 + std::exp(0.5 * cost_difference)));
  const Eigen::Matrix3d axes = upright_axes(down_obj_, state_.yaw_rad);
  const Eigen::Vector3d off_m = (axes.transpose() * (other.center_m - state_.center_m)).cwiseAbs();
  const double off_rad = std::abs(std::remainder(other.yaw_rad - state_.yaw_rad, std::numbers::pi));
  alternative_.center_m = (kAlternativeDecay * alternative_.center_m).cwiseMax(root * off_m);
  alternative_.size_m =
      (kAlternativeDecay * alternative_.size_m).cwiseMax(root * (other.size_m - state_.size_m).cwiseAbs());
  alternative_.yaw_rad = std::max(kAlternativeDecay * alternative_.yaw_rad, root * off_rad);
}

Box3Sigma BoxEstimator::sigma() const noexcept {
  return {(sigma_.center_m.cwiseAbs2() + alternative_.center_m.cwiseAbs2()).cwiseSqrt(),
          (sigma_.size_m.cwiseAbs2() + alternative_.size_m.cwiseAbs2()).cwiseSqrt(),
          std::hypot(sigma_.yaw_rad, alternative_.yaw_rad), sigma_.heading_known};
}

/// The next hypothesis in turn: another kind or, while the heading is unknown, another yaw.
BoxState BoxEstimator::next_hypothesis(const BoxFrame& frame, const BoxEvidence& evidence) const noexcept {
  const std::size_t kinds = evidence.kinds.size();
  const std::size_t turn = updates_ / kUpdatesPerHypothesis % (heading_ ? kinds : kinds + kYaws - 1);
  if (turn < kinds) {
    return start_at(frame, heading_ ? heading_->yaw_rad : state_.yaw_rad, evidence.kinds[turn]);
  }
  const double turned_rad = static_cast<double>(turn - kinds + 1) * std::numbers::pi / kYaws;
  return start_at(frame, state_.yaw_rad + turned_rad, most_likely_kind(frame));
}

/// A heading stays valid as long as the object's frame turns with it; otherwise its uncertainty grows.
void BoxEstimator::update_heading(const BoxFrame& frame, const Ground& ground_obj) noexcept {
  const double elapsed_s = timestamp_ns_ > 0 ? 1e-9 * static_cast<double>(frame.timestamp_ns - timestamp_ns_) : 0.0;
  timestamp_ns_ = frame.timestamp_ns;
  if (frame.heading) {
    if (!heading_) {
      alternative_ = Box3Sigma{};  // Rejected boxes had other yaws.
    }
    const Eigen::Vector3d along_world = upright_axes(frame.ground.down, frame.heading->yaw_rad).col(0);
    heading_ = Heading{upright_yaw(ground_obj.down, frame.T_world_obj.rotation.transpose() * along_world),
                       frame.heading->sigma_rad};
    sigma_.heading_known = true;
  } else if (heading_ && !frame.is_rotation_measured) {
    heading_->sigma_rad = std::hypot(heading_->sigma_rad, kTurnRateSigma_radps * elapsed_s);
  }
}

void BoxEstimator::accept(const BoxFit& fit) noexcept {
  state_ = fit.state;
  cost_ = fit.cost;
  const Eigen::Matrix3d axes = upright_axes(down_obj_, state_.yaw_rad);
  sigma_.center_m = (axes.transpose() * fit.covariance.topLeftCorner<3, 3>() * axes).diagonal().cwiseSqrt();
  sigma_.yaw_rad = std::hypot(std::sqrt(fit.covariance(3, 3)), kShapeYawSigma_rad);
  sigma_.size_m = fit.covariance.diagonal().tail<3>().cwiseSqrt();
}

void BoxEstimator::update(const BoxFrame& frame) noexcept {
  Ground ground_obj = frame.ground.in_frame(frame.T_world_obj.inverse());
  ground_obj.sigma_m = std::hypot(ground_obj.sigma_m, ground_obj.slope_sigma_rad * frame.T_obj_cam.translation.norm());
  down_world_ = frame.ground.down;
  down_obj_ = ground_obj.down;
  update_heading(frame, ground_obj);
  if (!frame.edges || (!known_ && frame.points.empty())) {
    return;
  }
  keep_view(frame);
  const BoxEvidence evidence{geometry_, views_, down_obj_, ground_obj, heading_, sizes_.kinds_of(frame.class_id)};
  ++updates_;
  if (!known_) {
    begin(frame, evidence);
    return;
  }
  const double off_rad = heading_ ? std::remainder(state_.yaw_rad - heading_->yaw_rad, 2.0 * std::numbers::pi) : 0.0;
  if (std::abs(off_rad) > 0.5 * kQuarter_rad) {
    // Its motion contradicts the yaw: the side or rear was taken for the front.
    begin(frame, evidence);
    return;
  }
  accept(fit_box(evidence, state_, kIterations));
  if (!frame.points.empty() && updates_ % kUpdatesPerHypothesis == 0) {
    test_hypothesis(evidence, next_hypothesis(frame, evidence), kHypothesisIterations, kAcceptanceMargin);
  }
}

Box3 BoxEstimator::box_in_world(const Se3& T_world_obj) const noexcept {
  const Eigen::Vector3d along = T_world_obj.rotation * upright_axes(down_obj_, state_.yaw_rad).col(0);
  return {T_world_obj * state_.center_m, state_.size_m, upright_yaw(down_world_, along), down_world_};
}

}  // namespace kinetrace::trajectory
