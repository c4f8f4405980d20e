// Reports each fault of a run's images once, with the remedy.
#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "camera/health_monitor.hpp"
#include "camera/pairing_keeper.hpp"
#include "config/input_config.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/hal/input_monitor.hpp"

namespace kinetrace::app {

/// Receives one line for the user.
using Warn = std::function<void(const std::string& warning)>;

/// Names of a run's inputs, for messages.
struct InputNames {
  std::string images;       ///< "recording kitti-raw:out/town", "camera file rig.yaml"
  std::string calibration;  ///< File.
};

/// The fault and its remedy in one line.
[[nodiscard]] std::string describe(hal::InputFault fault, const hal::InputMonitor& monitor, const InputNames& names,
                                   const StereoGeometry& geometry);

/// Faults of the calibration are not noted while it is `corrected`, nor in the first seconds of a run that `refines`
/// it: refinement reports them in more detail.
struct RefinedCalibration {
  bool refines = false;
  bool corrected = false;
};

/// Each fault that hal::InputMonitor detects is noted in health every time and reported once. Exchanged and identical
/// views invalidate all results; `policy` decides whether they end the run. Views out of step are paired anew where
/// possible.
class InputWatch {
 public:
  InputWatch(const hal::InputMonitor& monitor, const PairingKeeper& pairing, InputPolicy policy, InputNames names)
      : monitor_(monitor), pairing_(pairing), policy_(policy), names_(std::move(names)) {}

  /// Whether process() uses the next rectified pair; else the pair may be empty.
  [[nodiscard]] bool wants_pair() const noexcept { return monitor_.wants_pair(); }
  /// One frame, raw and rectified. Allocates only to report a fault. Errors: kBadFormat (the images cannot be used).
  [[nodiscard]] Status process(const StereoFrame& frame, const RectifiedPair& pair, HealthMonitor& health,
                               const Warn& warn, const RefinedCalibration& calibration = {});

 private:
  [[nodiscard]] bool is_worth_reporting(hal::InputFault fault) const noexcept;
  [[nodiscard]] bool is_left_to_refinement(hal::InputFault fault, const RefinedCalibration& calibration,
                                           std::int64_t now_ns) const noexcept;

  hal::InputMonitor monitor_;
  PairingKeeper pairing_;
  InputPolicy policy_;
  InputNames names_;
  std::bitset<hal::kInputFaultCount> reported_;
  std::optional<std::int64_t> begun_ns_;  ///< When the first frame was exposed.
};

}  // namespace kinetrace::app
