// One or two capture devices as a stereo camera that recovers from stalls and losses.
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

/// Estimated time offset between the views.
struct PairingStatus {
  double offset_ms = 0.0;       ///< Right minus left time stamp.
  double drift_ppm = 0.0;       ///< Drift of the offset.
  std::uint64_t relearned = 0;  ///< Number of re-estimations of the offset.
};

/// Pairs the images of two devices by mid-exposure time (FrameSynchronizer), or splits those of one device that
/// delivers both views side by side. `next` returns the newest pair; older ones count as outdated. Images whose
/// luminance lies in the device's buffer are not copied: the next call returns a pair's two buffers to the devices.
///
/// No frame for longer than `stall_timeout_ms` plus the exposure time is kStalled; `lost_timeout_ms` more, or a device
/// that reports its removal, is kLost with an error that names the camera: pairs end when one camera does. Both devices
/// are then closed; `recover` may be called at any rate, tries at growing intervals, and finds the same devices by
/// their stable id, wherever they have reappeared. Externally triggered devices are never lost for lack of images.
/// Times and frame numbers continue: frames are numbered by time, in nominal periods.
///
/// Memory from the arena: an image per device whose format has to be converted. Nothing allocates between start() and
/// an error.
class KINETRACE_API LiveStereoCamera final : public StereoCamera {
 public:
  [[nodiscard]] static std::size_t required_bytes(const LiveCameraConfig& config);
  /// Touches no device yet. Errors: kInvalidConfig, kCapacity, kUnsupported (pixel format).
  [[nodiscard]] static Result<LiveStereoCamera> create(const LiveCameraConfig& config, Arena& arena);
  /// The same in another environment than this machine; it must outlive the camera.
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
  /// From now on pairs left images with right ones that are `frames` later, to correct a view that the images show to
  /// be late by as much. False, without a change, where one image holds both views.
  bool move_pairing(int frames) noexcept;

 private:
  struct Impl;
  explicit LiveStereoCamera(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::hal
