#include "camera/input_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cli/formatted.hpp"

namespace kinetrace::app {
namespace {

using hal::InputFault;

struct FaultRule {
  InputFault fault;
  HealthReason reason;
  bool every_frame;   ///< Seen in every frame, not only at close looks.
  bool ends_the_run;  ///< Results from such images are invalid.
};
// Views out of step are noted by PairingKeeper.
constexpr std::array<FaultRule, hal::kInputFaultCount> kRules{{
    {InputFault::kViewsIdentical, HealthReason::kViewsIdentical, true, true},
    {InputFault::kViewsExchanged, HealthReason::kViewsExchanged, false, true},
    {InputFault::kViewsUnrelated, HealthReason::kViewsUnrelated, false, false},
    {InputFault::kNoParallax, HealthReason::kNoParallax, false, false},
    {InputFault::kBeyondInfinity, HealthReason::kCalibrationOff, false, false},
    {InputFault::kRowsApart, HealthReason::kCalibrationOff, false, false},
    {InputFault::kViewsOutOfStep, HealthReason::kViewsOutOfStep, false, false},
    {InputFault::kLeftFrozen, HealthReason::kImagesFrozen, true, false},
    {InputFault::kRightFrozen, HealthReason::kImagesFrozen, true, false},
}};

}  // namespace

Status InputWatch::process(const StereoFrame& frame, const RectifiedPair& pair, HealthMonitor& health, const Warn& warn,
                           const RefinedCalibration& calibration) {
  begun_ns_ = begun_ns_.value_or(frame.timestamp_ns);
  const bool looked_closely = monitor_.process(frame, pair);
  if (looked_closely && pairing_.process(monitor_.sync(), health)) {
    monitor_.restart_sync();
  }
  for (const FaultRule& rule : kRules) {
    if (!monitor_.holds(rule.fault) || is_left_to_refinement(rule.fault, calibration, frame.timestamp_ns)) {
      continue;
    }
    if (rule.fault != InputFault::kViewsOutOfStep && (looked_closely || rule.every_frame)) {
      health.note(rule.reason);
    }
    const auto index = static_cast<std::size_t>(rule.fault);
    if (reported_[index] || !is_worth_reporting(rule.fault)) {
      continue;
    }
    reported_.set(index);
    std::string what = describe(rule.fault, monitor_, names_, pair.geometry);
    if (rule.ends_the_run && policy_ == InputPolicy::kStop) {
      return fail(ErrorCode::kBadFormat, what + " (input.unusable: warn continues)");
    }
    warn(what);
  }
  return {};
}

bool InputWatch::is_left_to_refinement(InputFault fault, const RefinedCalibration& calibration,
                                       std::int64_t now_ns) const noexcept {
  constexpr std::int64_t kTimeToCorrect_ns = 2'000'000'000;
  const bool of_calibration = fault == InputFault::kRowsApart || fault == InputFault::kBeyondInfinity;
  return of_calibration && calibration.refines && (calibration.corrected || now_ns - *begun_ns_ < kTimeToCorrect_ns);
}

// One message per cause: identical views have no parallax either; a late view of two devices is corrected by the
// pairing.
bool InputWatch::is_worth_reporting(InputFault fault) const noexcept {
  switch (fault) {
    case InputFault::kNoParallax: return !monitor_.holds(InputFault::kViewsIdentical);
    case InputFault::kViewsOutOfStep: return !pairing_.can_shift_pairing();
    case InputFault::kRightFrozen: return !monitor_.holds(InputFault::kLeftFrozen);
    default: return true;
  }
}

std::string describe(InputFault fault, const hal::InputMonitor& monitor, const InputNames& names,
                     const StereoGeometry& geometry) {
  const hal::SyncReport& seen = monitor.sync();
  const std::string of_matches = " of " + std::to_string(seen.matches) + " matches";
  const std::string calibrate = "calibrate again (" + names.calibration + ")";
  switch (fault) {
    case InputFault::kViewsIdentical:
      return names.images + ": left and right images are equal bit by bit; give each view its own images or device";
    case InputFault::kViewsExchanged:
      return names.images + ": left and right are exchanged, " + std::to_string(seen.beyond_infinity) + of_matches +
             " have a negative disparity; exchange the images or devices of the two views";
    case InputFault::kViewsUnrelated:
      return names.images + ": only " + std::to_string(seen.matches) + " of " + std::to_string(seen.searched) +
             " patches of the left image are found in the right one: the images are of different moments or places, " +
             "turned, or out of focus; look at a pair of them";
    case InputFault::kNoParallax:
      return names.images + ": left and right show no disparity of a pixel or more: either both views come from one " +
             "camera, or everything is farther away than " +
             formatted("%.0f m, too far for this baseline", geometry.fx_px * geometry.baseline_m);
    case InputFault::kBeyondInfinity:
      return names.images + ": " + std::to_string(seen.beyond_infinity) + of_matches +
             " have a disparity below zero, where nothing can be: the calibration's yaw does not fit these images, or "
             "the views are exchanged; " +
             calibrate;
    case InputFault::kRowsApart:
      return names.images + ": matches lie " + formatted("%.1f px", seen.residual_px) +
             " off their row: the calibration does not fit these images; " + calibrate;
    case InputFault::kViewsOutOfStep:
      return names.images + ": " + to_string(seen.verdict) +
             ": depths are wrong wherever something moves; pair images of the same moment, or trigger both views "
             "together";
    case InputFault::kLeftFrozen:
    case InputFault::kRightFrozen:
      return names.images + ": " +
             (monitor.holds(InputFault::kLeftFrozen) && monitor.holds(InputFault::kRightFrozen) ? "both images are"
              : fault == InputFault::kLeftFrozen                                                ? "the left image is"
                                                 : "the right image is") +
             " the same bit by bit in every frame: the camera has stopped, or one image was stored again and again; "
             "restart the camera or record again";
  }
  return names.images;
}

}  // namespace kinetrace::app
