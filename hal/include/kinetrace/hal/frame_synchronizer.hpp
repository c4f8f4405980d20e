// Which left and which right image were taken together.
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
  std::int64_t tolerance_ns = 4'000'000;  ///< Of the time between the views, after the learnt offset; <= period / 2.

  [[nodiscard]] Status validate() const;
};

/// An image as far as pairing goes.
struct SyncFrame {
  int slot = -1;              ///< The caller's name for it.
  std::int64_t sequence = 0;  ///< Of its own stream; decides only whether a frame is new, never who its partner is.
  std::int64_t time_ns = 0;   ///< Mid-exposure; both views in one clock.
};

struct SyncPair {
  SyncFrame left;
  SyncFrame right;
};

/// A frame that will not be paired; the caller gives its buffer back.
struct SyncDrop {
  enum class Reason : std::uint8_t {
    kUnpaired,  ///< The other view has nothing from that time.
    kStale,     ///< Came again, or later than a newer one.
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
  std::uint64_t relocks = 0;      ///< The offset was learnt anew because nothing fitted any more.
  std::uint64_t clock_jumps = 0;  ///< One view's times went back.
};

/// Pairs two streams by time. Of two frames that do not fit together only the older one is dropped: the newer may still
/// find its partner. A pair is emitted once, in order of time, and no frame is in two pairs.
///
/// What the times of the views differ by constantly (latency of one device's stamps) and how that drifts is learnt with
/// an alpha-beta filter and taken off before tolerance is applied. Where nothing has fitted for `kRelockAfter` frames
/// of both views, the offset is learnt anew from their recent times. The learnt offset stays within about half a
/// period, unless one view's clock is off by more than `kJumpPeriods`: then the newest frames of both are taken to
/// belong together, which may be wrong by one frame; SyncMonitor sees that in the images, and move() mends it.
///
/// Never more than `kWaiting` frames of a view wait. No memory beyond the object, no clock; deterministic.
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

  /// Partners of left frames are from now on the right ones that come `frames` later than those so far. What one view
  /// has in excess is dropped as unpaired; no frame is used twice.
  void move(int frames) noexcept { jump_ns_ += frames * config_.period_ns; }

  /// Forgets a view's frames without dropping them: their buffers are gone. What was learnt stays.
  void forget(View view) noexcept;

  [[nodiscard]] const SyncCounters& counters() const noexcept { return counters_; }
  /// What right times are later than left ones, learnt so far.
  [[nodiscard]] std::int64_t offset_ns() const noexcept;
  /// How fast that grows, ns per ns.
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
  /// How much later the right frame is than it should be.
  [[nodiscard]] double misfit_ns(const SyncFrame& left, const SyncFrame& right) const noexcept;
  void learn(const SyncPair& pair) noexcept;
  void relock() noexcept;

  SyncConfig config_;
  std::array<Stream, 2> streams_;
  std::array<SyncDrop, kMaxDrops> drops_{};
  std::size_t drop_count_ = 0;
  SyncCounters counters_;
  std::int64_t jump_ns_ = 0;  ///< Whole difference of the clocks, and of frames; zero where both are one.
  double offset_ns_ = 0.0;    ///< Beyond that, at `offset_time_ns_`.
  double drift_ = 0.0;
  std::optional<std::int64_t> offset_time_ns_;
};

}  // namespace kinetrace::hal
