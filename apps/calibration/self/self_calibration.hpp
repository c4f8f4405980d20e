// A rig's calibration from an ordinary recording, given only the length of the baseline.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "rig_bundle.hpp"
#include "track_window.hpp"
#include "uncertainty.hpp"
#include "verdict.hpp"

namespace kinetrace::self_calibration {

struct SelfCalibrationOptions {
  double baseline_m = 0.0;
  std::size_t windows = 8;  ///< Stretches of frames, spread over the recording.
  std::size_t frames_per_window = 12;
  std::size_t pairs = 12;  ///< Number of frames for the first rig.
  LensPriors priors;
  int threads = 1;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct SelfCalibration {
  hal::RigCalibration calibration;
  RigModel rig;
  RigCovariance covariance = RigCovariance::Zero();
  Findings findings;
};

/// Errors: kInvalidArgument (baseline, too few frames), kBadCalibration if the recording does not determine the rig;
/// the message gives the reason and what to record. Takes some hundred MiB and a minute or two.
[[nodiscard]] Result<SelfCalibration> self_calibrate(const FrameSource& source, const SelfCalibrationOptions& options);

}  // namespace kinetrace::self_calibration
