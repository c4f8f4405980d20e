// What is wrong with the images of a stereo camera or recording, seen in the images themselves.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/sync_monitor.hpp"

namespace kinetrace::hal {

enum class InputFault : std::uint8_t {
  kViewsIdentical,  ///< Left and right images are equal bit by bit.
  kViewsExchanged,  ///< What the left view sees lies farther left in the left image: all disparities are negative.
  kViewsUnrelated,  ///< Hardly anything of the left image is in the right one.
  kNoParallax,      ///< No disparity reaches a pixel: one picture twice, or everything is too far away.
  kBeyondInfinity,  ///< Some disparities are negative: the calibration turns the views against each other.
  kRowsApart,       ///< Matches do not lie in one row: the calibration does not fit the images.
  kViewsOutOfStep,  ///< One view's images are a frame late.
  kLeftFrozen,      ///< The left image stays the same bit by bit.
  kRightFrozen,
};
inline constexpr std::size_t kInputFaultCount = 9;

/// Values of an image at places spread over it: a real sensor's noise never gives the same ones twice.
class KINETRACE_API ImageSample {
 public:
  /// Looks at `kColumns` x `kRows` pixels.
  void take(GrayView image) noexcept;
  /// False where nothing can be concluded: an image of (nearly) one value, as of a covered lens.
  [[nodiscard]] bool has_texture() const noexcept { return has_texture_; }
  [[nodiscard]] bool operator==(const ImageSample& other) const noexcept { return values_ == other.values_; }

 private:
  static constexpr int kColumns = 32;
  static constexpr int kRows = 32;
  std::array<std::uint8_t, static_cast<std::size_t>(kColumns) * kRows> values_{};
  bool has_texture_ = false;
};

/// Whether most of the recent looks show the same fault.
class KINETRACE_API FaultVotes {
 public:
  static constexpr std::size_t kVotes = 8;
  static constexpr std::size_t kMin = 3;

  void cast(bool faulty) noexcept;
  /// At least `kMin` of the last `kVotes`, and three quarters of them.
  [[nodiscard]] bool hold() const noexcept;

 private:
  std::bitset<kVotes> faulty_;
  std::size_t count_ = 0;
};

/// Looks at every pair as it comes (a thousand pixels of each image, some microseconds), and at every few pairs closely
/// (SyncMonitor). A fault holds once at least three looks agree: bit-equal images after three frames, the others after
/// three close looks. What the images do not show is not concluded: blank and dark images have no fault
/// here. Never allocates; memory from the arena: SyncMonitor's.
class KINETRACE_API InputMonitor {
 public:
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<InputMonitor> create(const SyncMonitorConfig& config, int width_px, int height_px,
                                                   Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const SyncMonitorConfig& config, int width_px, int height_px) {
    return SyncMonitor::required_bytes(config, width_px, height_px);
  }

  /// Whether the next rectified pair will be looked at; of others process() needs the raw frame alone.
  [[nodiscard]] bool wants_pair() const noexcept { return sync_.wants_pair(); }
  /// One frame, raw and rectified. True if the pair was looked at closely, so that sync() is new.
  bool process(const StereoFrame& frame, const RectifiedPair& pair) noexcept;
  [[nodiscard]] bool holds(InputFault fault) const noexcept { return holding_[static_cast<std::size_t>(fault)]; }
  [[nodiscard]] const SyncReport& sync() const noexcept { return sync_.report(); }
  /// Assesses anew whether views are in step: they are paired in another way from now on.
  void restart_sync() noexcept { sync_.restart(); }

 private:
  /// Of one view: as it was in the frame before, and for how many frames it has not changed.
  struct View {
    ImageSample last;
    bool begun = false;
    int unchanged = 0;
    void see(const ImageSample& now) noexcept;
  };
  explicit InputMonitor(const SyncMonitor& sync) : sync_(sync) {}
  void sample(const StereoFrame& frame) noexcept;
  void assess(const SyncReport& report, double focal_px) noexcept;
  void set(InputFault fault, bool holds) noexcept { holding_[static_cast<std::size_t>(fault)] = holds; }
  void vote(InputFault fault, bool faulty) noexcept;

  SyncMonitor sync_;
  View left_;
  View right_;
  int identical_ = 0;  ///< Frames in a row.
  std::array<FaultVotes, kInputFaultCount> votes_;
  std::bitset<kInputFaultCount> holding_;
};

}  // namespace kinetrace::hal
