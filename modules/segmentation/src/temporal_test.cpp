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

TemporalTest::TemporalTest(const StereoGeometry& geometry, const FrameHistory& history)
    : geometry_(geometry), history_(&history), step_px_(matching_step(geometry.width_px)) {
  for (int lag = 1; lag < history.size(); ++lag) {
    const PastFrame& now = history.at(0);
    const PastFrame& then = history.at(lag);
    const Se3 T_then_now = then.T_world_cam.inverse() * now.T_world_cam;
    const double elapsed_s = 1e-9 * static_cast<double>(now.timestamp_ns - then.timestamp_ns);
    steps_[static_cast<std::size_t>(lag)] = {T_then_now.rotation.cast<float>(), T_then_now.translation.cast<float>(),
                                             (elapsed_s * then.T_world_cam.rotation.transpose()).cast<float>()};
  }
}

float TemporalTest::overlap() const noexcept {
  const float side = static_cast<float>(kPatchPx * step_px_) / static_cast<float>(kCellPx);
  return side * side;
}

TemporalTest::Places TemporalTest::places(const Eigen::Vector3f& velocity_mps, int lag, float u, float v,
                                          float disparity_px) const noexcept {
  const Step& step = steps_[static_cast<std::size_t>(lag)];
  const auto fx = static_cast<float>(geometry_.fx_px);
  const auto fy = static_cast<float>(geometry_.fy_px);
  const auto cx = static_cast<float>(geometry_.cx_px);
  const auto cy = static_cast<float>(geometry_.cy_px);
  const float z = fx * static_cast<float>(geometry_.baseline_m) / disparity_px;
  const Eigen::Vector3f p((u - cx) / fx * z, (v - cy) / fy * z, z);
  const Eigen::Vector3f at_rest = step.rotation * p + step.translation;
  const Eigen::Vector3f moved = at_rest - step.back * velocity_mps;
  constexpr float kNearestM = 0.1F;
  constexpr float kNowhere = -1e3F;
  const auto project = [&](const Eigen::Vector3f& q) {
    return q.z() > kNearestM ? Eigen::Vector2f(fx * q.x() / q.z() + cx, fy * q.y() / q.z() + cy)
                             : Eigen::Vector2f(kNowhere, kNowhere);
  };
  return {project(at_rest), project(moved)};
}

int TemporalTest::discriminating_lag(const Eigen::Vector3f& velocity_mps, float u, float v,
                                     float disparity_px) const noexcept {
  for (int lag = 1; lag < history_->size(); ++lag) {
    const Places p = places(velocity_mps, lag, u, v, disparity_px);
    if ((p.at_rest - p.moved).norm() >= kDiscriminatingPx * static_cast<float>(step_px_)) {
      return lag;
    }
  }
  return history_->size() - 1;
}

// Corner of a cell's patch in the newest image; false without one, or without an image to compare with.
bool TemporalTest::patch(int lag, int cx, int cy, Eigen::Vector2i& corner) const noexcept {
  if (lag < 1 || lag >= history_->size()) {
    return false;
  }
  const GrayView now = history_->at(0).image;
  const int pitch = kCellPx / step_px_;
  corner = {cx * pitch + (pitch - kPatchPx) / 2, cy * pitch + (pitch - kPatchPx) / 2};
  return !now.empty() && !history_->at(lag).image.empty() && corner.minCoeff() >= 0 &&
         corner.x() + kPatchPx <= now.width && corner.y() + kPatchPx <= now.height;
}

float TemporalTest::cell_nats(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy,
                              float disparity_px) const noexcept {
  const float rest = residual(Eigen::Vector3f::Zero(), lag, cx, cy, disparity_px);
  const float moved = residual(velocity_mps, lag, cx, cy, disparity_px);
  return rest < 0.F || moved < 0.F ? 0.F : std::clamp((rest - moved) / kGreyPerNat, -kMaxNats, kMaxNats);
}

float TemporalTest::residual(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy,
                             float disparity_px) const noexcept {
  Eigen::Vector2i corner;
  if (!patch(lag, cx, cy, corner)) {
    return -1.F;
  }
  const Eigen::Vector2f center(cell_center(cx), cell_center(cy));
  const Eigen::Vector2f place = places(velocity_mps, lag, center.x(), center.y(), disparity_px).moved;
  const Eigen::Vector2f shift = (place - center) / static_cast<float>(step_px_);
  return dense_kernels().patch_difference(history_->at(0).image, corner.x(), corner.y(), history_->at(lag).image,
                                          shift.x(), shift.y());
}

void TemporalTest::add_equations(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy, float disparity_px,
                                 float noise_grey, Eigen::Matrix3f& information,
                                 Eigen::Vector3f& weighted) const noexcept {
  Eigen::Vector2i corner;
  if (!patch(lag, cx, cy, corner)) {
    return;
  }
  const Eigen::Vector2f center(cell_center(cx), cell_center(cy));
  const Eigen::Vector2f place = places(velocity_mps, lag, center.x(), center.y(), disparity_px).moved;
  const Eigen::Vector2f shift = (place - center) / static_cast<float>(step_px_);
  PatchSums s;
  if (!dense_kernels().patch_sums(history_->at(0).image, corner.x(), corner.y(), history_->at(lag).image, shift.x(),
                                  shift.y(), s)) {
    return;
  }
  const Step& step = steps_[static_cast<std::size_t>(lag)];
  const auto fx = static_cast<float>(geometry_.fx_px);
  const auto fy = static_cast<float>(geometry_.fy_px);
  const float z = fx * static_cast<float>(geometry_.baseline_m) / disparity_px;
  // Derivative of the place in the earlier image by the velocity.
  Eigen::Matrix<float, 2, 3> jacobian;
  jacobian << fx, 0.F, static_cast<float>(geometry_.cx_px) - place.x(),  //
      0.F, fy, static_cast<float>(geometry_.cy_px) - place.y();
  jacobian = -jacobian * step.back / (z * static_cast<float>(step_px_));
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
  return history_->size() - 1;
}

float TemporalTest::elapsed_s(int lag) const noexcept {
  return 1e-9F * static_cast<float>(history_->at(0).timestamp_ns - history_->at(lag).timestamp_ns);
}

float TemporalTest::support_nats(const DenseView& dense, const Eigen::Vector3f& velocity_mps, float u, float v,
                                 float disparity_px, float radius_m) const noexcept {
  const int lag = discriminating_lag(velocity_mps, u, v, disparity_px);
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
      total += cell_nats(velocity_mps, lag, cx, cy, d);
    }
  }
  return total / overlap();
}

}  // namespace kinetrace::segmentation
