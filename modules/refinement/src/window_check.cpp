#include "window_check.hpp"

#include <bit>
#include <cmath>
#include <string>

namespace kinetrace::refinement {
namespace {

Status check_observations(const BundleWindow& window) {
  const std::uint32_t mask = frame_mask(window.T_body_cam.size());
  for (std::size_t p = 0; p < window.points.size(); ++p) {
    const BundlePoint& point = window.points[p];
    if ((point.frames & mask) == 0) {
      continue;
    }
    if (!point.position_m.allFinite()) {
      return fail(ErrorCode::kInvalidArgument,
                  "position of window point " + std::to_string(p) + " is not finite: remove the point");
    }
    for (std::uint32_t frames = point.frames & mask; frames != 0; frames &= frames - 1) {
      const auto frame = static_cast<std::size_t>(std::countr_zero(frames));
      if (!is_valid(window.observation(p, frame))) {
        return fail(ErrorCode::kInvalidArgument, "observation of window point " + std::to_string(p) + " in frame " +
                                                     std::to_string(frame) +
                                                     " is not finite or has no weight: clear its bit in `frames`");
      }
    }
  }
  return {};
}

}  // namespace

Status check_geometry(const StereoGeometry& geometry) {
  const bool finite = std::isfinite(geometry.fx_px) && std::isfinite(geometry.fy_px) && std::isfinite(geometry.cx_px) &&
                      std::isfinite(geometry.cy_px) && std::isfinite(geometry.baseline_m);
  if (!finite || geometry.fx_px <= 0.0 || geometry.fy_px <= 0.0 || geometry.baseline_m <= 0.0) {
    return fail(ErrorCode::kBadCalibration,
                "stereo geometry needs positive finite fx, fy and baseline: check the calibration");
  }
  return {};
}

Status check_turns(std::span<const TurnPrior> turns, std::size_t frames) {
  if (!turns.empty() && turns.size() != frames) {
    return fail(ErrorCode::kInvalidArgument, "window has " + std::to_string(turns.size()) + " turns for " +
                                                 std::to_string(frames) + " frames: give one for each, or none");
  }
  for (std::size_t k = 0; k < turns.size(); ++k) {
    if (!turns[k].R_before_now.allFinite() || !(turns[k].inverse_sigma_rad >= 0.0) ||
        !std::isfinite(turns[k].inverse_sigma_rad)) {
      return fail(ErrorCode::kInvalidArgument,
                  "turn of window frame " + std::to_string(k) + " is not finite or has a negative weight");
    }
  }
  return {};
}

bool is_valid(const BundleObservation& observation) noexcept {
  return std::isfinite(observation.u_left_px) && std::isfinite(observation.v_px) &&
         !std::isinf(observation.u_right_px) && std::isfinite(observation.inverse_sigma_px) &&
         observation.inverse_sigma_px > 0.F;
}

Status check_window(const BundleWindow& window) {
  const std::size_t frames = window.T_body_cam.size();
  if (frames == 0 || window.points.empty()) {
    return {};
  }
  if (frames > kMaxWindowFrames) {
    return fail(ErrorCode::kCapacity, "window holds " + std::to_string(frames) + " frames, at most " +
                                          std::to_string(kMaxWindowFrames) + " fit");
  }
  if (window.observations.size() < window.points.size() * frames) {
    return fail(ErrorCode::kInvalidArgument, "window has " + std::to_string(window.observations.size()) +
                                                 " observations, points x frames = " +
                                                 std::to_string(window.points.size() * frames) + " are needed");
  }
  if ((window.fixed_frames & frame_mask(frames)) == 0) {
    return fail(ErrorCode::kInvalidArgument, "window has no fixed frame: set at least one bit of fixed_frames");
  }
  for (std::size_t k = 0; k < frames; ++k) {
    if (!window.T_body_cam[k].is_finite()) {
      return fail(ErrorCode::kInvalidArgument, "pose of window frame " + std::to_string(k) + " is not finite");
    }
  }
  if (Status turns = check_turns(window.turns, frames); !turns) {
    return turns;
  }
  if (Status geometry = check_geometry(window.geometry); !geometry) {
    return geometry;
  }
  return check_observations(window);
}

}  // namespace kinetrace::refinement
