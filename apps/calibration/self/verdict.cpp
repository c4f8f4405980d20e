#include "verdict.hpp"

#include <cstdio>
#include <string>

namespace kinetrace::self_calibration {
namespace {

template <typename... Values>
Unexpected<Error> refused(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return fail(ErrorCode::kBadCalibration, std::string("self-calibration refused: ") + text);
}

}  // namespace

Status verdict(const Findings& findings) {
  constexpr double kMinTravel_px = 4.0;
  constexpr double kMinParallax_px = 4.0;
  constexpr std::size_t kMinWindows = 3;
  constexpr std::size_t kMinPoints = 100;  // Per window.
  constexpr double kMaxPlaneShare = 0.95;
  constexpr double kMinUsed = 0.3;
  constexpr double kWorstFit_px = 0.5;
  constexpr double kWorstFocal = 0.005;
  constexpr double kWorstDepth = 0.03;
  const SceneEvidence& scene = findings.scene;
  if (findings.windows < kMinWindows || scene.points < kMinPoints * findings.windows) {
    return refused(
        "too few points could be followed from frame to frame and from left to right (%zu in %zu stretches); "
        "record something with texture, in good light, both cameras in focus and in step",
        scene.points, findings.windows);
  }
  if (scene.travel_px < kMinTravel_px) {
    return refused("the camera is at rest (points move %.2f px); record while driving, flying or walking",
                   scene.travel_px);
  }
  if (scene.parallax_px < kMinParallax_px) {
    return refused(
        "the camera turns but does not travel (%.1f px of the image's motion come from its path); record "
        "while moving past things at different distances",
        scene.parallax_px);
  }
  if (scene.plane_share > kMaxPlaneShare) {
    return refused(
        "nearly all that is seen (%.0f %%) lies on one plane, like a wall; record something with depth, near "
        "and far",
        100.0 * scene.plane_share);
  }
  if (findings.used_share < kMinUsed || findings.sigma_px > kWorstFit_px) {
    return refused(
        "no rig explains the images (%.0f %% of the points fit, to %.2f px); are the cameras in step, firmly "
        "mounted, and with ordinary lenses? Fisheye lenses need `kinetrace calibrate --target`",
        100.0 * findings.used_share, findings.sigma_px);
  }
  if (!(findings.focal_sigma < kWorstFocal)) {
    return refused("the focal length stays open (%.1f %%); record longer, with turns and with things near and far",
                   100.0 * findings.focal_sigma);
  }
  if (!(findings.depth_sigma < kWorstDepth)) {
    return refused("distances stay open (%.1f %% at fifty baselines); record longer, past things near and far",
                   100.0 * findings.depth_sigma);
  }
  return {};
}

}  // namespace kinetrace::self_calibration
