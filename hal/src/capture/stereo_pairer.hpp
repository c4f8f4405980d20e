// Makes the newest stereo pair from the images of one or two streams.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "capture/capture_environment.hpp"
#include "capture/capture_stream.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_synchronizer.hpp"
#include "kinetrace/hal/stereo_camera.hpp"
#include "synchronization/missed_frames.hpp"

namespace kinetrace::hal {

struct StereoViews {
  GrayView left;
  GrayView right;
};

/// Pairs the images of two streams by time, or makes a pair of each image of one stream that shows both views side by
/// side. Keeps the newest pair; returns every other image to its device and counts the reason. Streams, environment and
/// counters must outlive it. Never allocates.
class StereoPairer {
 public:
  StereoPairer(std::span<CaptureStream> streams, CaptureEnvironment& environment, const SyncConfig& config, int buffers,
               CameraCounters& counters);

  /// Resets the estimated time offset of the streams.
  void reset() noexcept { synchronizer_ = FrameSynchronizer(config_); }
  /// Call it after starting the streams: no frames count as missed before their first pair.
  void begin() noexcept;

  /// Takes the available images, at most as many as the devices can queue. Errors: kDisconnected.
  [[nodiscard]] Status gather();
  /// Waits until a stream may have an image or until that time. Call it after gather().
  void wait(std::int64_t now_ns, std::int64_t until_ns);

  /// The newest pair, if it was not taken before. Its images stay valid until release_taken().
  [[nodiscard]] std::optional<SyncPair> take();
  void release_taken() noexcept;
  void release_all() noexcept;
  /// None if an image cannot be read.
  [[nodiscard]] std::optional<StereoViews> views(const SyncPair& pair);
  /// Counts the frames missed before the delivered `pair`.
  void count_gaps(const SyncPair& pair) noexcept;

  [[nodiscard]] bool side_by_side() const noexcept { return streams_.size() == 1; }
  /// As FrameSynchronizer::move. False for side-by-side images.
  bool move(int frames) noexcept;
  [[nodiscard]] const FrameSynchronizer& synchronizer() const noexcept { return synchronizer_; }

 private:
  [[nodiscard]] Result<bool> take_image(std::size_t camera);
  /// Returns the number of streams restarted since the last call.
  std::uint64_t forget_restarted() noexcept;
  void offer(const SyncPair& pair) noexcept;
  void count_drops() noexcept;
  void release(std::optional<SyncPair>& pair) noexcept;
  std::array<WaitHandle, 2> wait_for_images(std::int64_t until_ns);

  std::span<CaptureStream> streams_;  ///< Left and right, or the one with both.
  CaptureEnvironment* environment_;
  SyncConfig config_;
  int buffers_;
  CameraCounters* counters_;
  FrameSynchronizer synchronizer_;
  MissedFrames missed_;
  std::array<int, 2> generations_{};
  std::optional<SyncPair> taken_;
  std::optional<SyncPair> newest_;  ///< Not yet taken.
  bool falsely_ready_ = false;      ///< A device reported itself ready but had no image.
};

}  // namespace kinetrace::hal
