// One or two capture devices as a stereo camera that outlives their troubles.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"
#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal {

class CaptureEnvironment;

/// How left and right relate in time, as far as measured.
struct PairingStatus {
  double offset_ms = 0.0;       ///< What right images are later than left ones, by their stamps.
  double drift_ppm = 0.0;       ///< How fast that grows.
  std::uint64_t relearned = 0;  ///< Times that the offset had to be learnt anew.
};

/// Pairs the images of two devices by mid-exposure time (FrameSynchronizer), or splits those of one device that
/// delivers both views side by side. `next` gives the newest pair there is; older ones count as outdated. Images whose
/// luminance lies in the device's buffer are viewed there, without a copy: a pair's two buffers go back to the devices
/// with the next call.
///
/// No frame for longer than `stall_timeout_ms`, with the exposure time on top, is kStalled; `lost_timeout_ms` more, or
/// a device that reports to be gone, is kLost with an error that names the camera: pairs end when one camera does. Both
/// devices are then closed; `recover` may be called as often as one likes, tries at growing intervals, and looks for
/// the same devices by their stable id, wherever they have reappeared. Devices that follow a trigger line are never
/// lost for want of images. Times and frame numbers go on where they were: frames are numbered by time, in nominal
/// periods.
///
/// Memory from the arena: an image per device whose format has to be converted. Nothing allocates between start() and
/// an error.
class KINETRACE_API LiveStereoCamera final : public StereoCamera {
 public:
  [[nodiscard]] static std::size_t required_bytes(const LiveCameraConfig& config);
  /// Touches no device yet. Errors: kInvalidConfig, kCapacity, kUnsupported (pixel format).
  [[nodiscard]] static Result<LiveStereoCamera> create(const LiveCameraConfig& config, Arena& arena);
  /// The same in an environment that is not this machine; it must outlive the camera.
  [[nodiscard]] static Result<LiveStereoCamera> create(const LiveCameraConfig& config, Arena& arena,
                                                       CaptureEnvironment& environment);

  LiveStereoCamera(LiveStereoCamera&&) noexcept;
  LiveStereoCamera& operator=(LiveStereoCamera&&) noexcept;
  ~LiveStereoCamera() override;

  [[nodiscard]] Status open() override;
  [[nodiscard]] Status start() override;
  [[nodiscard]] Result<StereoFrame> next(std::chrono::milliseconds timeout) override;
  [[nodiscard]] Status stop() override;
  [[nodiscard]] Status recover() override;
  void close() noexcept override;

  [[nodiscard]] CameraState state() const noexcept override;
  [[nodiscard]] const CameraInfo& info() const noexcept override;
  [[nodiscard]] const CameraCounters& counters() const noexcept override;
  [[nodiscard]] PairingStatus pairing() const noexcept;
  /// Left images are from now on paired with right ones that are `frames` later: for whoever sees in the images that
  /// one view is late by as much. False, and nothing changed, where both views come in one image.
  bool move_pairing(int frames) noexcept;

 private:
  struct Impl;
  explicit LiveStereoCamera(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::hal
