// Says what is wrong with a run's images: once, with the place to mend it.
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

/// Takes a line for the user.
using Warn = std::function<void(const std::string& warning)>;

/// Where a run's input comes from, in words.
struct InputNames {
  std::string images;       ///< "recording kitti-raw:out/town", "camera file rig.yaml"
  std::string calibration;  ///< File.
};

/// What is wrong and what to do about it, in a line.
[[nodiscard]] std::string describe(hal::InputFault fault, const hal::InputMonitor& monitor, const InputNames& names,
                                   const StereoGeometry& geometry);

/// Faults of the calibration are not noted while it is `corrected`, nor in the first seconds of a run that `refines`
/// it, which will say more about them.
struct RefinedCalibration {
  bool refines = false;
  bool corrected = false;
};

/// Each fault that hal::InputMonitor finds is noted in health every time, and said once. Exchanged and identical views
/// end the run if `policy` says so: nothing computed from them is right. Views out of step are mended where they can
/// be.
class InputWatch {
 public:
  InputWatch(const hal::InputMonitor& monitor, const PairingKeeper& pairing, InputPolicy policy, InputNames names)
      : monitor_(monitor), pairing_(pairing), policy_(policy), names_(std::move(names)) {}

  /// Whether process() will look at the next rectified pair; others may be empty.
  [[nodiscard]] bool wants_pair() const noexcept { return monitor_.wants_pair(); }
  /// One frame, raw and rectified. Never allocates unless there is something to say.
  /// Errors: kBadFormat (the images cannot be used).
  [[nodiscard]] Status process(const StereoFrame& frame, const RectifiedPair& pair, HealthMonitor& health,
                               const Warn& warn, const RefinedCalibration& calibration = {});

 private:
  [[nodiscard]] bool is_worth_saying(hal::InputFault fault) const noexcept;
  [[nodiscard]] bool is_left_to_refinement(hal::InputFault fault, const RefinedCalibration& calibration,
                                           std::int64_t now_ns) const noexcept;

  hal::InputMonitor monitor_;
  PairingKeeper pairing_;
  InputPolicy policy_;
  InputNames names_;
  std::bitset<hal::kInputFaultCount> said_;
  std::optional<std::int64_t> begun_ns_;  ///< When the first frame was exposed.
};

}  // namespace kinetrace::app
