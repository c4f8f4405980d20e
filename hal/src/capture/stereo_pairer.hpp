// From the images of one or two streams to the newest stereo pair.
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
/// side. Keeps the newest pair; gives every other image back to its device and counts why. Streams, environment and
/// counters must outlive it. Never allocates.
class StereoPairer {
 public:
  StereoPairer(std::span<CaptureStream> streams, CaptureEnvironment& environment, const SyncConfig& config, int buffers,
               CameraCounters& counters);

  /// Forgets what was learnt about the times of the streams.
  void reset() noexcept { synchronizer_ = FrameSynchronizer(config_); }
  /// The streams have just been started: nothing is missed before their first pair.
  void begin() noexcept;

  /// Takes the images that the devices have, at most as many as they can have queued. Errors: kDisconnected.
  [[nodiscard]] Status gather();
  /// Until a stream may have an image or that time has come. After gather().
  void wait(std::int64_t now_ns, std::int64_t until_ns);

  /// The newest pair, if there is one that was not taken yet. Its images stay valid until release_taken().
  [[nodiscard]] std::optional<SyncPair> take();
  void release_taken() noexcept;
  void release_all() noexcept;
  /// None where an image cannot be read.
  [[nodiscard]] std::optional<StereoViews> views(const SyncPair& pair);
  /// `pair` is delivered. Counts the frames that were missed before it.
  void count_gaps(const SyncPair& pair) noexcept;

  [[nodiscard]] bool side_by_side() const noexcept { return streams_.size() == 1; }
  /// As FrameSynchronizer::move. False where there is nothing to pair.
  bool move(int frames) noexcept;
  [[nodiscard]] const FrameSynchronizer& synchronizer() const noexcept { return synchronizer_; }

 private:
  [[nodiscard]] Result<bool> take_image(std::size_t camera);
  /// Returns how many streams have been started again since the last call.
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
  bool falsely_ready_ = false;      ///< A device reported itself ready and had no image.
};

}  // namespace kinetrace::hal
