#include "kinetrace/segmentation/temporal_test.hpp"

#include <algorithm>
#include <cmath>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {
namespace {

/// Displacement between the two hypotheses at which images can tell them apart, pixels of the matching images.
constexpr float kTellingPx = 2.5F;
/// Mean grey difference of a patch that is one nat, and where it is cut off.
constexpr float kGreyPerNat = 1.F;
constexpr float kMaxNats = 3.F;
/// Metres by which what belongs together may differ in depth.
constexpr float kDepthM = 0.8F;
/// Log-likelihood ratio below which a cell is ground.
constexpr float kGroundNats = -2.F;

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

int TemporalTest::telling_lag(const Eigen::Vector3f& velocity_mps, float u, float v,
                              float disparity_px) const noexcept {
  for (int lag = 1; lag < history_->size(); ++lag) {
    const Places p = places(velocity_mps, lag, u, v, disparity_px);
    if ((p.at_rest - p.moved).norm() >= kTellingPx * static_cast<float>(step_px_)) {
      return lag;
    }
  }
  return history_->size() - 1;
}

float TemporalTest::cell_nats(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy,
                              float disparity_px) const noexcept {
  if (lag < 1 || lag >= history_->size()) {
    return 0.F;
  }
  const GrayView now = history_->at(0).image;
  const GrayView then = history_->at(lag).image;
  const int pitch = kCellPx / step_px_;
  const int x = cx * pitch + (pitch - kPatchPx) / 2;
  const int y = cy * pitch + (pitch - kPatchPx) / 2;
  if (now.empty() || then.empty() || x < 0 || y < 0 || x + kPatchPx > now.width || y + kPatchPx > now.height) {
    return 0.F;
  }
  const Eigen::Vector2f center(cell_center(cx), cell_center(cy));
  const Places p = places(velocity_mps, lag, center.x(), center.y(), disparity_px);
  const auto step = static_cast<float>(step_px_);
  const Eigen::Vector2f at_rest = (p.at_rest - center) / step;
  const Eigen::Vector2f with_it = (p.moved - center) / step;
  const DenseKernels& kernels = dense_kernels();
  const float rest = kernels.patch_difference(now, x, y, then, at_rest.x(), at_rest.y());
  const float moved = kernels.patch_difference(now, x, y, then, with_it.x(), with_it.y());
  return rest < 0.F || moved < 0.F ? 0.F : std::clamp((rest - moved) / kGreyPerNat, -kMaxNats, kMaxNats);
}

float TemporalTest::support_nats(const DenseView& dense, const Eigen::Vector3f& velocity_mps, float u, float v,
                                 float disparity_px, float radius_m) const noexcept {
  const int lag = telling_lag(velocity_mps, u, v, disparity_px);
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
          dense.ground.object_nats(cell_center(cx), cell_center(cy), d, dense.disparity.sigma_px()) < kGroundNats) {
        continue;
      }
      total += cell_nats(velocity_mps, lag, cx, cy, d);
    }
  }
  return total / overlap();
}

}  // namespace kinetrace::segmentation
