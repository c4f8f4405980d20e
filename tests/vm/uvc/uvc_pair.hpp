// The simulated left and right camera, as a backend names them.
#pragma once

#include <string>

#include "kinetrace/hal/live_camera_config.hpp"
#include "simulated_uvc_camera.hpp"

namespace kinetrace::hal::test {

/// Plugged in at first use, for the rest of the program.
class UvcPair {
 public:
  static UvcPair& instance();

  SimulatedUvcCamera left{0};
  SimulatedUvcCamera right{1};

  /// A mode that both have, slow enough for an emulated processor.
  [[nodiscard]] CaptureConfig config(CaptureBackend backend, int view, PixelFormat format = PixelFormat::kGrey8) const;
  /// Waits until the backend lists `count` cameras. Throws std::runtime_error at the time-out.
  static void wait_until_listed(CaptureBackend backend, std::size_t count);

 private:
  UvcPair();
  ~UvcPair() = default;
};

}  // namespace kinetrace::hal::test
