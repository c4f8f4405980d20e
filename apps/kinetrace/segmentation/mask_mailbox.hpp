// Passes masks from the network's thread to the pipeline's.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/instance_masks.hpp"

namespace kinetrace::app {

struct MaskMailboxConfig {
  int width_px = 0;  ///< Of the rectified images.
  int height_px = 0;
  bool right = false;  ///< Masks of the right image are requested, too.
  std::chrono::milliseconds timeout{50};
};

struct MaskCounters {
  std::uint64_t frames_taken = 0;           ///< Complete and in time.
  std::uint64_t frames_timed_out = 0;       ///< Not complete in time.
  std::uint64_t frames_unsent = 0;          ///< Not waited for, for lack of senders.
  std::uint64_t messages = 0;               ///< Received.
  std::uint64_t messages_late = 0;          ///< Of these: for a past frame ...
  std::uint64_t messages_early = 0;         ///< ... for a frame ahead without a free slot ...
  std::uint64_t messages_of_other_run = 0;  ///< ... with another time stamp than their frame ...
  std::uint64_t messages_invalid = 0;       ///< ... or with invalid size, view, pieces, run lengths or amount.
};

/// Reasons and remedies for refused messages.
inline constexpr std::string_view kMasksOfOtherRun =
    "their time is not that of the frame they name, so they are of another run; give each run a dds.device of its own, "
    "end senders that answer an earlier run, and let senders repeat the request's timestamp_ns";
inline constexpr std::string_view kMasksInvalid =
    "another image size than the request tells, pieces or runs that do not add up, or too many of them";

/// Assembles masks of a few frames from pieces until the pipeline takes them. One thread offers, one awaits. All memory
/// is allocated at the start. Data from the network is untrusted and checked here. Pieces are assembled by sender: a
/// bad sender cannot spoil another's masks, and the first complete set is taken. Masks with another time stamp than
/// their frame belong to another run.
class MaskMailbox final : public MaskSource {
 public:
  static constexpr std::size_t kFrames = 4;          ///< Frames in progress at once, counted for each sender.
  static constexpr std::size_t kMaxMasks = 256;      ///< Of one image.
  static constexpr std::size_t kMaxRuns = 32 << 10;  ///< Of one image, all masks together.
  static constexpr std::uint32_t kMaxPieces = 64;    ///< Of one image.

  [[nodiscard]] static std::size_t required_bytes(const MaskMailboxConfig& config);
  /// The arena is sized by required_bytes.
  MaskMailbox(const MaskMailboxConfig& config, Arena& arena);
  /// `ask` is called by the pipeline's thread for each request and must not block. Set before the first frame.
  void on_request(std::function<void()> ask) { ask_ = std::move(ask); }

  // The pipeline's thread.
  void request(const RectifiedPair& pair) noexcept override;
  [[nodiscard]] const MaskSet* await(std::int64_t frame_index) noexcept override;

  // The network's thread.
  void offer(const MaskMessage& message) noexcept;
  /// The newest request not taken yet.
  [[nodiscard]] std::optional<MaskRequest> take_request() noexcept;
  /// Without senders, await() does not wait.
  void set_senders(std::uint32_t senders) noexcept;

  // Any thread.

  /// False if no sender appeared in this time.
  [[nodiscard]] bool wait_for_sender(std::chrono::milliseconds at_most);
  [[nodiscard]] MaskCounters counters() const;

 private:
  struct ViewMasks {
    FixedVector<RunLengthMask> masks;
    FixedVector<std::uint16_t> runs;
    std::uint64_t pieces_seen = 0;  ///< One bit each.
    std::uint32_t pieces = 0;       ///< 0: none received yet.
    [[nodiscard]] bool is_whole() const noexcept;
    void clear() noexcept;
  };
  /// The messages of one sender for one frame.
  struct Slot {
    bool in_use = false;
    bool is_bad = false;  ///< A piece was invalid; the set will never be complete.
    std::uint64_t sender = 0;
    std::int64_t frame_index = 0;
    std::int64_t timestamp_ns = 0;
    std::uint64_t messages = 0;
    std::array<ViewMasks, 2> views;
    [[nodiscard]] bool is_of(const MaskMessage& message) const noexcept;
  };

  using Slots = std::array<Slot, kFrames>;

  static void carve(const MaskMailboxConfig& config, Arena& arena, Slots& slots);
  [[nodiscard]] bool is_valid(const MaskMessage& message) const noexcept;
  [[nodiscard]] bool is_whole(const Slot& slot) const noexcept;
  [[nodiscard]] const Slot* find_whole(std::int64_t frame_index) const noexcept;
  /// All senders have sent invalid data for this frame.
  [[nodiscard]] bool is_given_up(std::int64_t frame_index) const noexcept;
  /// The message's slot, or a new one; null if none is free. The awaited frame always gets one, unless as many senders
  /// as slots have begun with it.
  [[nodiscard]] Slot* reserve_slot(const MaskMessage& message) noexcept;
  /// The slot to replace for the awaited frame: a bad one, else the frame farthest ahead; null if none.
  [[nodiscard]] Slot* dispensable() noexcept;
  void release_for(const RectifiedPair& pair) noexcept;
  [[nodiscard]] static bool store(const MaskMessage& message, ViewMasks& view) noexcept;

  const MaskMailboxConfig config_;
  std::function<void()> ask_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // All guarded by the mutex.
  Slots slots_;
  std::optional<MaskRequest> request_;
  std::optional<MaskRequest> awaited_;  ///< The newest requested frame; older ones are past.
  std::uint32_t senders_ = 0;
  MaskCounters counters_;
  MaskSet taken_;  ///< Masks of the slot that the pipeline reads.
};

}  // namespace kinetrace::app
