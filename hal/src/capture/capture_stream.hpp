// One device of a live camera, from opening to the image in luminance.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "capture/capture_environment.hpp"
#include "capture/luminance_reader.hpp"
#include "capture/rate_meter.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_synchronizer.hpp"
#include "kinetrace/hal/stereo_camera.hpp"
#include "kinetrace/hal/timeline_guard.hpp"
#include "synchronization/image_numbering.hpp"

namespace kinetrace::hal {

/// Opens its device by name, from the second time on by stable id if the name is a path; keeps captured images by slot;
/// converts stamps to plausible mid-exposure times.
class CaptureStream {
 public:
  [[nodiscard]] static std::size_t required_bytes(const CaptureConfig& config);
  /// `camera` is for messages: "left camera".
  [[nodiscard]] static Result<CaptureStream> create(std::string view, const CaptureConfig& config, Arena& arena,
                                                    CaptureEnvironment& environment);

  /// Errors: as CaptureDevice::open; kDisconnected if it finds another device than before.
  [[nodiscard]] Status open();
  [[nodiscard]] Status start();
  [[nodiscard]] Status stop();
  void close() noexcept;

  /// Takes one image for pairing, with its image_number() as `sequence`; none if it is unusable, with the reason
  /// counted. Errors: kDisconnected.
  [[nodiscard]] Result<std::optional<SyncFrame>> take(CameraCounters& counters);
  /// Call it when the device has no image: that distinguishes images that waited in the driver from jumps of the clock.
  void note_empty() noexcept { empty_ns_ = environment_->now_ns(); }
  [[nodiscard]] Result<GrayView> luminance(int slot);
  void release(int slot) noexcept;

  /// Of the newest image, damaged ones included: see ImageNumbering.
  [[nodiscard]] std::int64_t image_number() const noexcept { return numbering_.number(); }
  /// Increases with every start(), which invalidates all slots.
  [[nodiscard]] int generation() const noexcept { return generation_; }
  [[nodiscard]] int wait_fd() const noexcept { return device_->wait_fd(); }
  [[nodiscard]] std::int64_t last_image_ns() const noexcept { return last_image_ns_; }
  /// Of the newest image, if the device reports it; else as set.
  [[nodiscard]] std::int64_t exposure_ns() const noexcept { return exposure_ns_; }
  /// "left camera (name of the device)".
  [[nodiscard]] std::string described() const;
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  static constexpr std::size_t kMaxSlots = 64;

  CaptureStream(std::string view, CaptureConfig config, LuminanceReader reader, CaptureEnvironment& environment);
  [[nodiscard]] Status restart(const Error& cause);
  [[nodiscard]] Result<std::optional<SyncFrame>> handle_no_image(const Error& error);
  [[nodiscard]] std::int64_t plausible_time_ns(const CapturedImage& image, CameraCounters& counters) noexcept;
  std::int64_t number_of(const CapturedImage& image, std::optional<std::int64_t> time_ns) noexcept;
  [[nodiscard]] bool is_the_same(const CaptureInfo& info) const;
  void note_exposure(const CapturedImage& image) noexcept;
  [[nodiscard]] bool is_usable(const CapturedImage& image) const noexcept;
  [[nodiscard]] Status check_rate(const CapturedImage& image);
  [[nodiscard]] std::int64_t mid_exposure_ns(const CapturedImage& image) const noexcept;

  std::string view_;
  CaptureConfig config_;
  LuminanceReader reader_;
  CaptureEnvironment* environment_;
  std::unique_ptr<CaptureDevice> device_;
  std::string name_;
  struct Identity {
    std::string name;
    std::string stable_id;
    std::string serial;
  };
  Identity identity_;  ///< Empty until the device was open once.
  std::array<CapturedImage, kMaxSlots> images_{};
  TimelineGuard timeline_;
  RateMeter rate_;
  ImageNumbering numbering_;
  std::int64_t last_image_ns_ = 0;  ///< When the last image was taken, damaged ones included.
  std::int64_t empty_ns_ = 0;       ///< When the device last had none.
  struct Arrival {
    std::int64_t earliest_ns = 0;
    std::int64_t latest_ns = 0;  ///< When it was taken.
  };
  Arrival arrival_;                       ///< Of the last valid image.
  std::optional<std::int64_t> stamp_ns_;  ///< Of the last image since start().
  std::int64_t exposure_ns_ = 0;
  int generation_ = 0;
  int restarts_in_a_row_ = 0;
};

}  // namespace kinetrace::hal
