// Pairs left and right images that were taken at the same time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

enum class View : std::uint8_t { kLeft, kRight };

struct KINETRACE_API SyncConfig {
  std::int64_t period_ns = 33'333'333;    ///< Nominal time between frames.
  std::int64_t tolerance_ns = 4'000'000;  ///< Maximum time between the views, less the offset; <= period / 2.

  [[nodiscard]] Status validate() const;
};

/// Number and time of an image, for pairing.
struct SyncFrame {
  int slot = -1;              ///< Chosen by the caller.
  std::int64_t sequence = 0;  ///< Of its own stream; tells whether a frame is new, does not affect pairing.
  std::int64_t time_ns = 0;   ///< Mid-exposure; both views in one clock.
};

struct SyncPair {
  SyncFrame left;
  SyncFrame right;
};

/// A frame that will not be paired; the caller gives its buffer back.
struct SyncDrop {
  enum class Reason : std::uint8_t {
    kUnpaired,  ///< The other view has no frame of that time.
    kStale,     ///< Repeated, or out of order.
    kReset,     ///< Its clock jumped back.
  };
  View view = View::kLeft;
  SyncFrame frame;
  Reason reason = Reason::kUnpaired;
};

/// Running totals since construction.
struct SyncCounters {
  std::uint64_t pairs = 0;
  std::array<std::uint64_t, 2> unpaired{};  ///< By view.
  std::array<std::uint64_t, 2> stale{};
  std::uint64_t slips = 0;        ///< The offset outgrew half a period: partners changed by one frame.
  std::uint64_t relocks = 0;      ///< Re-estimations of the offset, when no frames matched any more.
  std::uint64_t clock_jumps = 0;  ///< One view's times went back.
};

/// Pairs two streams by time. Of two frames that do not match only the older one is dropped: the newer may still match
/// a later frame. Pairs are emitted in order of time; no frame is in two pairs.
///
/// An alpha-beta filter estimates the offset between the views' times (latency of one device's stamps) and its drift;
/// the tolerance applies to the residual. After `kRelockAfter` frames of both views without a pair, the offset is
/// re-estimated from their recent times. The offset stays within about half a period, unless one view's clock is off by
/// more than `kJumpPeriods`: then the newest frames of both views are assumed to match, which may be wrong by one
/// frame; SyncMonitor detects that in the images, and move() corrects it.
///
/// At most `kWaiting` frames of a view wait. No memory beyond the object, no clock; deterministic.
class KINETRACE_API FrameSynchronizer {
 public:
  static constexpr std::size_t kWaiting = 2;
  static constexpr int kRelockAfter = 6;
  static constexpr int kJumpPeriods = 4;

  /// `config` must be valid.
  explicit FrameSynchronizer(const SyncConfig& config) : config_(config) {}

  /// Takes a frame. Afterwards ask for pairs until there is none, then for drops until there is none.
  void add(View view, const SyncFrame& frame) noexcept;
  [[nodiscard]] std::optional<SyncPair> next_pair() noexcept;
  [[nodiscard]] std::optional<SyncDrop> next_drop() noexcept;

  /// From now on pairs left frames with right frames that are `frames` later than before. Surplus frames of one view
  /// are dropped as unpaired; no frame is used twice.
  void move(int frames) noexcept { coarse_offset_ns_ += frames * config_.period_ns; }

  /// Discards a view's frames without reporting drops: their buffers are gone. Keeps the offset and its drift.
  void forget(View view) noexcept;

  [[nodiscard]] const SyncCounters& counters() const noexcept { return counters_; }
  /// Estimated right minus left time.
  [[nodiscard]] std::int64_t offset_ns() const noexcept;
  /// Drift of the offset, ns per ns.
  [[nodiscard]] double drift() const noexcept { return drift_; }

 private:
  static constexpr std::size_t kRemembered = 8;
  static constexpr std::size_t kMaxDrops = 4 * kWaiting;

  struct Stream {
    std::array<SyncFrame, kWaiting> waiting{};
    std::size_t count = 0;
    std::array<std::int64_t, kRemembered> times_ns{};  ///< The newest last.
    std::size_t remembered = 0;
    std::optional<SyncFrame> last;
    int stale_in_a_row = 0;
    int since_pair = 0;  ///< Frames added since the last pair.

    [[nodiscard]] const SyncFrame& front() const noexcept { return waiting[0]; }
    SyncFrame pop() noexcept;
    void remember(std::int64_t time_ns) noexcept;
  };

  [[nodiscard]] Stream& stream(View view) noexcept { return streams_[static_cast<std::size_t>(view)]; }
  [[nodiscard]] bool is_stale(Stream& stream, const SyncFrame& frame) noexcept;
  void restart(View view) noexcept;
  void drop(View view, const SyncFrame& frame, SyncDrop::Reason reason) noexcept;
  void drop_front(View view) noexcept { drop(view, stream(view).pop(), SyncDrop::Reason::kUnpaired); }
  [[nodiscard]] double predicted_offset_ns(std::int64_t left_time_ns) const noexcept;
  /// Innovation: right time minus its prediction from the left time.
  [[nodiscard]] double innovation_ns(const SyncFrame& left, const SyncFrame& right) const noexcept;
  void learn(const SyncPair& pair) noexcept;
  void relock() noexcept;

  SyncConfig config_;
  std::array<Stream, 2> streams_;
  std::array<SyncDrop, kMaxDrops> drops_{};
  std::size_t drop_count_ = 0;
  SyncCounters counters_;
  std::int64_t coarse_offset_ns_ = 0;  ///< Difference of the clocks, and moves by whole frames; 0: one clock.
  double offset_ns_ = 0.0;             ///< Remaining offset at `offset_time_ns_`.
  double drift_ = 0.0;
  std::optional<std::int64_t> offset_time_ns_;
};

}  // namespace kinetrace::hal
