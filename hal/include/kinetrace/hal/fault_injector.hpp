// Injects the known faults of cameras at given frames.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal {

enum class FaultKind : std::uint8_t {
  kUnplug,     ///< "unplug": the device disappears, and is back after VALUE attempts to recover (2).
  kStuck,      ///< "stuck": a time-out in place of the frame.
  kSlow,       ///< "slow": the frame comes VALUE milliseconds later (100).
  kDrop,       ///< "drop": the frame is lost.
  kDuplicate,  ///< "duplicate": the frame comes twice.
  kReorder,    ///< "reorder": the frame comes after the one that follows it.
  kCorrupt,    ///< "corrupt": the lower VALUE per cent (60) of one view's image are missing.
  kDesync,     ///< "desync": the right image is that of the frame before.
  kClock,      ///< "clock": from the first frame on, times are VALUE seconds later (3600; may be negative).
  kSize,       ///< "size": the images have half the width and height.
};

/// Faults by frame, counted from 0 as the camera delivers them.
struct Fault {
  FaultKind kind = FaultKind::kDrop;
  std::int64_t first = 0;
  std::int64_t last = 0;     ///< Included.
  double probability = 1.0;  ///< Of each frame in that range; a function of seed and frame.
  double value = 0.0;
};

struct FaultPlan {
  std::vector<Fault> faults;
  std::uint64_t seed = 1;
  [[nodiscard]] bool empty() const noexcept { return faults.empty(); }
};

/// Names of the kinds that parse_faults accepts.
[[nodiscard]] KINETRACE_API std::span<const std::string_view> fault_kind_names() noexcept;

/// From "KIND@FIRST[-LAST][%PERCENT][:VALUE]", several with commas, and "seed=N" among them:
/// "drop@10-12,clock@40:-5,duplicate@0-999%10,seed=7". Errors: kInvalidArgument, with the invalid part.
[[nodiscard]] KINETRACE_API Result<FaultPlan> parse_faults(std::string_view text);

/// Decorates a camera with faults. The same plan on the same frames gives the same stream. Stalls, losses and
/// recoveries are simulated here, without the decorated camera: the timeouts of a LiveStereoCamera and its reopening at
/// growing intervals are not exercised. Frames of another size than announced pass unchanged. Memory from the arena:
/// five images.
class KINETRACE_API FaultInjector final : public StereoCamera {
 public:
  /// `width_px` x `height_px`: of the camera's images.
  [[nodiscard]] static std::size_t required_bytes(int width_px, int height_px);
  /// Errors: kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<FaultInjector>> create(std::unique_ptr<StereoCamera> camera,
                                                                     FaultPlan plan, int width_px, int height_px,
                                                                     Arena& arena);

  [[nodiscard]] Status open() override { return camera_->open(); }
  [[nodiscard]] Status start() override;
  [[nodiscard]] Result<StereoFrame> next(std::chrono::milliseconds timeout) override;
  [[nodiscard]] Status stop() override;
  [[nodiscard]] Status recover() override;
  void close() noexcept override;
  [[nodiscard]] std::string image_name(std::int64_t frame_index, bool is_left) const override {
    return camera_->image_name(frame_index, is_left);
  }

  [[nodiscard]] CameraState state() const noexcept override { return state_.value_or(camera_->state()); }
  [[nodiscard]] const CameraInfo& info() const noexcept override { return camera_->info(); }
  /// Counters of the camera, plus the injected drops (as gaps), stalls, losses and recoveries.
  [[nodiscard]] const CameraCounters& counters() const noexcept override;

 private:
  struct Storage {
    std::array<MutableGrayView, 2> modified;  ///< Modified images of the current frame.
    std::array<MutableGrayView, 2> kept;      ///< The frame held back.
    MutableGrayView last_right;
  };
  FaultInjector(std::unique_ptr<StereoCamera> camera, FaultPlan plan, const Storage& storage);
  static void carve(int width_px, int height_px, Arena& arena, Storage& storage);

  void forget() noexcept;
  [[nodiscard]] bool has_room_for(const StereoFrame& frame) const noexcept;
  [[nodiscard]] const Fault* active(FaultKind kind, std::int64_t number) const noexcept;
  [[nodiscard]] Result<StereoFrame> produce(std::chrono::milliseconds timeout);
  [[nodiscard]] Result<StereoFrame> unplug(const Fault& fault);
  [[nodiscard]] Result<StereoFrame> stall();
  void apply_faults(StereoFrame& frame, std::int64_t number);
  void cut_off(StereoFrame& frame, std::int64_t number, double percent);
  void lag_right(StereoFrame& frame, bool lags);
  [[nodiscard]] StereoFrame keep(const StereoFrame& frame);

  std::unique_ptr<StereoCamera> camera_;
  FaultPlan plan_;
  Storage storage_;
  std::optional<CameraState> state_;  ///< None: the camera's own.
  std::int64_t number_ = 0;           ///< Of the next frame from the camera.
  std::int64_t gone_until_ = -1;      ///< Last frame lost to an unplugged device.
  int attempts_left_ = 0;
  bool has_last_right_ = false;
  std::optional<StereoFrame> waiting_;    ///< To be delivered next.
  std::optional<StereoFrame> held_back_;  ///< To be delivered after the next frame.
  CameraCounters own_;
  mutable CameraCounters sum_;
};

}  // namespace kinetrace::hal
