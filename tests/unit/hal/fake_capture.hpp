// A machine with scripted capture devices and a clock of its own: everything happens at exactly known times.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture_environment.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal::test {

inline constexpr std::int64_t kMs = 1'000'000;

/// One exposure of a fake sensor, for a script to change.
struct Shot {
  std::int64_t number = 0;
  std::int64_t stamp_ns = 0;
  std::int64_t arrival_ns = 0;
  std::int64_t sequence = 0;
  bool lost = false;     ///< Never arrives.
  bool damaged = false;  ///< Arrives with the driver's error flag.
  bool cut = false;      ///< Arrives with half its bytes.
};

/// A sensor and its wire. Pixels of shot `n` are all `(n - lag_shots) % 256`; side by side, the right half is that plus
/// 100.
struct FakeSensor {
  std::string path;
  std::string stable_id;
  std::string serial = {};
  std::int64_t period_ns = 33 * kMs;
  std::int64_t phase_ns = 0;  ///< When shot 0 is stamped.
  std::int64_t latency_ns = 5 * kMs;
  int lag_shots = 0;  ///< Shows an image this many shots old under the current stamp.
  bool plugged = true;
  bool side_by_side = false;
  bool stream_broken = false;  ///< next() fails with kIo until it is started again.
  bool never_mends = false;    ///< ... and even then.
  bool mute = false;
  std::int64_t taking_ns = 0;  ///< Duration of next() for an image.
  bool falsely_ready = false;  ///< Reports itself ready (poll: POLLERR) though next() has nothing.
  std::optional<double> exposure_us = {};
  std::optional<std::int64_t> given_exposure_ns = {};  ///< Reported with every image, as by automatic exposure.
  bool tells_rate = true;
  TimestampKind timestamp_kind = TimestampKind::kEndOfExposure;
  bool sequence_counts_losses = true;
  int width_px = 0;  ///< Width that it really sets; 0: as requested.
  std::function<void(Shot&)> script = {};

  // Counters of calls and buffers.
  int opened = 0;
  int started = 0;
  int in_use = 0;  ///< Buffers held by the camera.
  int most_in_use = 0;
};

/// For fake sensors at these paths, at their rate; `right` empty: for one sensor with both views side by side.
[[nodiscard]] LiveCameraConfig live_config(const std::string& left, const std::string& right, int width_px = 640,
                                           int height_px = 480);

class FakeMachine final : public CaptureEnvironment {
 public:
  FakeSensor& add(FakeSensor sensor);

  [[nodiscard]] Result<std::unique_ptr<CaptureDevice>> make_device(const CaptureConfig& config) override;
  [[nodiscard]] std::int64_t now_ns() override { return now_ns_; }
  void wait(std::span<WaitHandle> handles, std::int64_t until_ns) override;

  void pass(std::int64_t duration_ns) { now_ns_ += duration_ns; }
  int attempts = 0;  ///< Calls of make_device.

 private:
  friend class FakeDevice;
  std::int64_t now_ns_ = 1'000'000 * kMs;
  int next_id_ = 0;
  std::vector<std::unique_ptr<FakeSensor>> sensors_;
  std::vector<class FakeDevice*> devices_;
};

}  // namespace kinetrace::hal::test
