// Detects faults of a stereo camera or recording from its images.
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
  kViewsExchanged,  ///< Left and right are swapped: all disparities are negative.
  kViewsUnrelated,  ///< Hardly any patch of the left image has a match in the right one.
  kNoParallax,      ///< All disparities are below a pixel: one picture twice, or a scene too far away.
  kBeyondInfinity,  ///< Some disparities are negative: the yaw between the views is calibrated wrongly.
  kRowsApart,       ///< Matches do not lie in one row: the calibration does not fit the images.
  kViewsOutOfStep,  ///< One view's images are a frame late.
  kLeftFrozen,      ///< The left image stays the same bit by bit.
  kRightFrozen,
};
inline constexpr std::size_t kInputFaultCount = 9;

/// Pixels of an image on a sparse grid: the noise of a sensor never yields the same values twice.
class KINETRACE_API ImageSample {
 public:
  /// Samples `kColumns` x `kRows` pixels.
  void take(GrayView image) noexcept;
  /// False for an image of (nearly) one value, as of a covered lens: its equality is no evidence.
  [[nodiscard]] bool has_texture() const noexcept { return has_texture_; }
  [[nodiscard]] bool operator==(const ImageSample& other) const noexcept { return values_ == other.values_; }

 private:
  static constexpr int kColumns = 32;
  static constexpr int kRows = 32;
  std::array<std::uint8_t, static_cast<std::size_t>(kColumns) * kRows> values_{};
  bool has_texture_ = false;
};

/// Whether most of the recent measurements show the same fault.
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

/// Samples every pair (a thousand pixels of each image, some microseconds), and matches patches in every few pairs
/// (SyncMonitor). A fault holds once at least three measurements agree: bit-equal images after three frames, other
/// faults after three matched pairs. Blank and dark images are no evidence of a fault. Never allocates; memory from the
/// arena: SyncMonitor's.
class KINETRACE_API InputMonitor {
 public:
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<InputMonitor> create(const SyncMonitorConfig& config, int width_px, int height_px,
                                                   Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const SyncMonitorConfig& config, int width_px, int height_px) {
    return SyncMonitor::required_bytes(config, width_px, height_px);
  }

  /// Whether process() will read the next rectified pair; otherwise it needs the raw frame alone.
  [[nodiscard]] bool wants_pair() const noexcept { return sync_.wants_pair(); }
  /// One frame, raw and rectified. True if the pair was matched, so that sync() is new.
  bool process(const StereoFrame& frame, const RectifiedPair& pair) noexcept;
  [[nodiscard]] bool holds(InputFault fault) const noexcept { return holding_[static_cast<std::size_t>(fault)]; }
  [[nodiscard]] const SyncReport& sync() const noexcept { return sync_.report(); }
  /// Restarts the check of synchronisation after a change of the pairing.
  void restart_sync() noexcept { sync_.restart(); }

 private:
  /// Last sample of one view, and for how many frames it has not changed.
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
