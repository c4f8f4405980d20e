#include "kinetrace/segmentation/temporal_test.hpp"

#include <algorithm>
#include <cmath>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {
namespace {

/// Least displacement between the two hypotheses for a reliable test, pixels of the matching images.
constexpr float kDiscriminatingPx = 2.5F;
/// Mean grey difference of a patch per nat, and the bound of a cell's ratio.
constexpr float kGreyPerNat = 1.F;
constexpr float kMaxNats = 3.F;
/// Largest difference in depth within an object, metres.
constexpr float kDepthM = 0.8F;

}  // namespace

Eigen::Vector2f PastPlaces::at(float u, float v, float disparity_px) const noexcept {
  constexpr float kNowhere = -1e3F;
  const Eigen::Vector4f place = warp_ * Eigen::Vector4f(u, v, 1.F, disparity_px);
  return place.w() > 0.F ? Eigen::Vector2f(place.head<2>() / place.z()) : Eigen::Vector2f(kNowhere, kNowhere);
}

Eigen::Matrix<float, 2, 3> PastPlaces::jacobian(float u, float v, float disparity_px,
                                                const Eigen::Vector2f& place) const noexcept {
  const float z = warp_.row(2) * Eigen::Vector4f(u, v, 1.F, disparity_px);
  return disparity_px / z * (by_velocity_.topRows<2>() - place * by_velocity_.row(2));
}

// A point X = f b / d K^-1 (u, v, 1) was at R X + t - s v, with s the elapsed time in the axes of the earlier camera:
// its homogeneous place is K R K^-1 (u, v, 1) + d K (t - s v) / (f b).
TemporalTest::TemporalTest(const StereoGeometry& geometry, const FrameHistory& history)
    : geometry_(geometry), history_(&history), step_px_(matching_step(geometry.width_px)) {
  constexpr double kNearestM = 0.1;
  const double fb = geometry.fx_px * geometry.baseline_m;
  Eigen::Matrix3d k;
  k << geometry.fx_px, 0.0, geometry.cx_px, 0.0, geometry.fy_px, geometry.cy_px, 0.0, 0.0, 1.0;
  for (int lag = 1; lag < history.size(); ++lag) {
    const PastFrame& now = history.at(0);
    const PastFrame& then = history.at(lag);
    const Se3 T_then_now = then.T_world_cam.inverse() * now.T_world_cam;
    const double elapsed_s = 1e-9 * static_cast<double>(now.timestamp_ns - then.timestamp_ns);
    Eigen::Matrix4d warp;
    warp.topLeftCorner<3, 3>() = k * T_then_now.rotation * k.inverse();
    warp.topRightCorner<3, 1>() = k * T_then_now.translation / fb;
    warp.row(3) = warp.row(2) - kNearestM / fb * Eigen::RowVector4d::UnitW();
    PastPlaces& places = at_rest_[static_cast<std::size_t>(lag)];
    places.lag_ = lag;
    places.warp_ = warp.cast<float>();
    places.by_velocity_ = (-elapsed_s / fb * k * then.T_world_cam.rotation.transpose()).cast<float>();
  }
}

PastPlaces TemporalTest::places(const Eigen::Vector3f& velocity_mps, int lag) const noexcept {
  PastPlaces places = at_rest_[static_cast<std::size_t>(lag)];
  const Eigen::Vector3f shift = places.by_velocity_ * velocity_mps;
  places.warp_.col(3) += Eigen::Vector4f(shift.x(), shift.y(), shift.z(), shift.z());
  return places;
}

float TemporalTest::overlap() const noexcept {
  const float side = static_cast<float>(kPatchPx * step_px_) / static_cast<float>(kCellPx);
  return side * side;
}

int TemporalTest::discriminating_lag(const Eigen::Vector3f& velocity_mps, float u, float v,
                                     float disparity_px) const noexcept {
  for (int lag = 1; lag < history_->size(); ++lag) {
    const Hypotheses h = hypotheses(velocity_mps, lag);
    if ((h.at_rest.at(u, v, disparity_px) - h.moved.at(u, v, disparity_px)).norm() >=
        kDiscriminatingPx * static_cast<float>(step_px_)) {
      return lag;
    }
  }
  return std::max(0, history_->size() - 1);
}

bool TemporalTest::find_patch(const PastPlaces& places, int cx, int cy, float disparity_px,
                              Patch& patch) const noexcept {
  if (places.lag() < 1 || places.lag() >= history_->size()) {
    return false;
  }
  const GrayView now = history_->at(0).image;
  const int pitch = kCellPx / step_px_;
  patch.corner = {cx * pitch + (pitch - kPatchPx) / 2, cy * pitch + (pitch - kPatchPx) / 2};
  if (now.empty() || history_->at(places.lag()).image.empty() || patch.corner.minCoeff() < 0 ||
      patch.corner.x() + kPatchPx > now.width || patch.corner.y() + kPatchPx > now.height) {
    return false;
  }
  const Eigen::Vector2f center(cell_center(cx), cell_center(cy));
  patch.place = places.at(center.x(), center.y(), disparity_px);
  patch.shift = (patch.place - center) / static_cast<float>(step_px_);
  return true;
}

float TemporalTest::cell_nats(const Hypotheses& hypotheses, int cx, int cy, float disparity_px) const noexcept {
  const float rest = residual(hypotheses.at_rest, cx, cy, disparity_px);
  const float moved = residual(hypotheses.moved, cx, cy, disparity_px);
  return rest < 0.F || moved < 0.F ? 0.F : std::clamp((rest - moved) / kGreyPerNat, -kMaxNats, kMaxNats);
}

float TemporalTest::residual(const PastPlaces& places, int cx, int cy, float disparity_px) const noexcept {
  Patch patch;
  if (!find_patch(places, cx, cy, disparity_px, patch)) {
    return -1.F;
  }
  return dense_kernels().patch_difference(history_->at(0).image, patch.corner.x(), patch.corner.y(),
                                          history_->at(places.lag()).image, patch.shift.x(), patch.shift.y());
}

void TemporalTest::add_equations(const PastPlaces& places, int cx, int cy, float disparity_px, float noise_grey,
                                 Eigen::Matrix3f& information, Eigen::Vector3f& weighted) const noexcept {
  Patch patch;
  PatchSums s;
  if (!find_patch(places, cx, cy, disparity_px, patch) ||
      !dense_kernels().patch_sums(history_->at(0).image, patch.corner.x(), patch.corner.y(),
                                  history_->at(places.lag()).image, patch.shift.x(), patch.shift.y(), s)) {
    return;
  }
  const Eigen::Matrix<float, 2, 3> jacobian =
      places.jacobian(cell_center(cx), cell_center(cy), disparity_px, patch.place) / static_cast<float>(step_px_);
  Eigen::Matrix2f gradients;
  gradients << s.xx, s.xy, s.xy, s.yy;
  // Cauchy weight, against occlusions and other objects.
  const float variance = noise_grey * noise_grey;
  const float weight =
      1.F / ((1.F + s.rr / static_cast<float>(kPatchPx * kPatchPx) / (4.F * variance)) * variance * overlap());
  information += weight * jacobian.transpose() * gradients * jacobian;
  weighted -= weight * jacobian.transpose() * Eigen::Vector2f(s.xr, s.yr);
}

int TemporalTest::lag_after(float seconds) const noexcept {
  for (int lag = 1; lag < history_->size(); ++lag) {
    if (elapsed_s(lag) >= seconds) {
      return lag;
    }
  }
  return std::max(0, history_->size() - 1);
}

float TemporalTest::elapsed_s(int lag) const noexcept {
  return 1e-9F * static_cast<float>(history_->at(0).timestamp_ns - history_->at(lag).timestamp_ns);
}

float TemporalTest::support_nats(const DenseView& dense, const Eigen::Vector3f& velocity_mps, float u, float v,
                                 float disparity_px, float radius_m) const noexcept {
  const Hypotheses moves_or_rests = hypotheses(velocity_mps, discriminating_lag(velocity_mps, u, v, disparity_px));
  const ImageView<const float> cells = dense.disparity.disparity_px();
  const auto fb = static_cast<float>(geometry_.fx_px * geometry_.baseline_m);
  const float noise = 2.F * dense.disparity.sigma_px();
  const float far_px = fb / (fb / disparity_px + kDepthM) - noise;
  const float near_px = fb / std::max(fb / disparity_px - kDepthM, 0.2F) + noise;
  const float radius = radius_m * disparity_px / static_cast<float>(geometry_.baseline_m) / kCellPx;
  const float mx = u / kCellPx;
  const float my = v / kCellPx;
  float total = 0.F;
  for (int cy = std::max(0, static_cast<int>(my - radius));
       cy <= std::min(cells.height - 1, static_cast<int>(my + radius)); ++cy) {
    for (int cx = std::max(0, static_cast<int>(mx - radius));
         cx <= std::min(cells.width - 1, static_cast<int>(mx + radius)); ++cx) {
      const float d = cells.row(cy)[cx];
      if (d < far_px || d > near_px ||
          dense.ground.object_nats(cell_center(cx), cell_center(cy), d, dense.disparity.sigma_px()) <
              GroundPlane::kGroundNats) {
        continue;
      }
      total += cell_nats(moves_or_rests, cx, cy, d);
    }
  }
  return total / overlap();
}

}  // namespace kinetrace::segmentation
