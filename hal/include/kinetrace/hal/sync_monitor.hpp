// Checks from the images whether left and right were taken at the same time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

struct KINETRACE_API SyncMonitorConfig {
  int interval_frames = 5;     ///< Measures every so many-th pair, with the one before it.
  int max_disparity_px = 128;  ///< Nearer points are not matched.

  [[nodiscard]] Status validate() const;
};

enum class SyncVerdict : std::uint8_t {
  kUnknown,  ///< Not enough vertical image motion so far to tell.
  kInStep,
  kRightLate,   ///< The right image is that of the frame before.
  kRightEarly,  ///< The left image is that of the frame before.
};

struct SyncReport {
  SyncVerdict verdict = SyncVerdict::kUnknown;
  SyncVerdict latest = SyncVerdict::kUnknown;  ///< Verdict of the last measurement alone.
  int agreeing = 0;  ///< Number of the last `kVotes` conclusive measurements with this verdict.
  int measurements = 0;
  int matches = 0;       ///< Of the last measurement.
  int searched = 0;      ///< Patches with texture, for which a match was sought.
  int frames_apart = 0;  ///< Between its two pairs: 1; 2 or 3: less conclusive; 4 or more (reported as 4): not at all.
  double residual_px = 0.0;         ///< Median distance of matches from their epipolar line, of the last measurement.
  double signed_residual_px = 0.0;  ///< Median of right row less left row.
  int in_front = 0;                 ///< Matches with a disparity above a pixel, of the last measurement.
  int beyond_infinity = 0;          ///< ... below minus one pixel, impossible for a real point.
  double disparity_px = 0.0;        ///< Median.
};

/// In a rectified pair matches lie in one row. If one image is a frame late and the rig has moved meanwhile, they do
/// not; but they do between that image and the other view's image of the frame before. Three pairings are therefore
/// measured: both images of one frame, and either image with the other's predecessor. The verdict is the majority of
/// the recent conclusive measurements. If the pair before is two or three frames old, because processing does not keep
/// up with the camera, the three residuals are compared with those of uniform motion. A miscalibrated rig has a
/// residual in all three pairings and is not mistaken for a late view. Purely sideways motion of the rig is not
/// conclusive.
///
/// The first `kEarlyLooks` measurements come sooner, of one frame alone: they do not assess synchronisation.
///
/// Works on images of half the size: at most 64 patches of 16x8 pixels, +-12 px of rows, sums of absolute differences.
/// Within one frame negative disparities are searched, too. About 1.3 ms for 640x480 in every `interval_frames`-th
/// frame, less than .2 ms in the one before, nothing in others. Memory from the arena: one image pair. Never allocates.
class KINETRACE_API SyncMonitor {
 public:
  static constexpr std::size_t kVotes = 8;
  static constexpr int kEarlyLooks = 3;

  [[nodiscard]] static std::size_t required_bytes(const SyncMonitorConfig& config, int width_px, int height_px);
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<SyncMonitor> create(const SyncMonitorConfig& config, int width_px, int height_px,
                                                  Arena& arena);

  /// Whether process() will read the next pair; otherwise its images may be left out.
  [[nodiscard]] bool wants_pair() const noexcept { return next_look() != Look::kNone; }
  /// True if this pair was measured, so that the report is new.
  bool process(const RectifiedPair& pair) noexcept;
  [[nodiscard]] const SyncReport& report() const noexcept { return report_; }
  /// Restarts the assessment after a change of the pairing.
  void restart() noexcept;

 private:
  struct Storage {
    std::array<MutableGrayView, 2> now;     ///< Left, right, half the size.
    std::array<MutableGrayView, 2> before;  ///< Of the pair before.
  };
  /// Measurement of one pairing of images.
  struct Residual {
    int matches = 0;
    double median_px = 0.0;
    double signed_px = 0.0;
    int searched = 0;
    int in_front = 0;
    int beyond_infinity = 0;
    double disparity_px = 0.0;
  };
  SyncMonitor(const SyncMonitorConfig& config, const Storage& storage) : config_(config), storage_(storage) {}
  enum class Look : std::uint8_t { kNone, kEarly, kBefore, kNow };
  [[nodiscard]] Look next_look() const noexcept;
  /// Measures one frame alone, without its predecessor.
  [[nodiscard]] Residual look(const RectifiedPair& pair) noexcept;
  static void carve(int width_px, int height_px, Arena& arena, Storage& storage);
  [[nodiscard]] Residual measure(GrayView left, GrayView right, int least_disparity_px) const noexcept;
  void vote(const Residual& same, const Residual& right_late, const Residual& right_early) noexcept;
  void vote_by_motion(const Residual& same, const Residual& right_late, const Residual& right_early,
                      int frames_apart) noexcept;
  void cast(SyncVerdict verdict_now) noexcept;

  SyncMonitorConfig config_;
  Storage storage_;
  std::int64_t pairs_ = 0;
  std::int64_t before_index_ = 0;
  std::array<SyncVerdict, kVotes> votes_{};
  std::size_t vote_count_ = 0;
  SyncReport report_;
};

[[nodiscard]] constexpr const char* to_string(SyncVerdict verdict) noexcept {
  switch (verdict) {
    case SyncVerdict::kUnknown: return "unknown";
    case SyncVerdict::kInStep: return "in step";
    case SyncVerdict::kRightLate: return "right image one frame late";
    case SyncVerdict::kRightEarly: return "left image one frame late";
  }
  return "unknown";
}

}  // namespace kinetrace::hal
