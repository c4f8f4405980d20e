// Masks on their way from the network's thread to the pipeline's.
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
  bool right = false;  ///< Masks of the right image are wanted too.
  std::chrono::milliseconds timeout{50};
};

struct MaskCounters {
  std::uint64_t frames_taken = 0;           ///< Whole, and in time.
  std::uint64_t frames_timed_out = 0;       ///< Waited for in vain.
  std::uint64_t frames_unsent = 0;          ///< Not waited for, since nobody is there who could send any.
  std::uint64_t messages = 0;               ///< Received.
  std::uint64_t messages_late = 0;          ///< Of these: of a frame that is over ...
  std::uint64_t messages_early = 0;         ///< ... of one ahead for which there is no room ...
  std::uint64_t messages_of_other_run = 0;  ///< ... of another time than the frame they name ...
  std::uint64_t messages_invalid = 0;  ///< ... or not what they should be: size, view, pieces, run lengths, amount.
};

/// Why messages are refused, and what to do.
inline constexpr std::string_view kMasksOfOtherRun =
    "their time is not that of the frame they name, so they are of another run; give each run a dds.device of its own, "
    "end senders that answer an earlier run, and let senders repeat the request's timestamp_ns";
inline constexpr std::string_view kMasksInvalid =
    "another image size than the request tells, pieces or runs that do not add up, or too many of them";

/// Holds masks of a few frames, each whole only with all its pieces, until the pipeline asks. One thread offers, one
/// awaits. All memory is taken at the start. What arrives is checked here: nothing that a network brings is trusted.
/// Pieces are put together by sender: what one sends spoils nothing but its own, and the first to be whole is taken.
/// Masks of another time than the frame they name are of another run.
class MaskMailbox final : public MaskSource {
 public:
  static constexpr std::size_t kFrames = 4;          ///< That may be under way at once, each sender's by itself.
  static constexpr std::size_t kMaxMasks = 256;      ///< Of one image.
  static constexpr std::size_t kMaxRuns = 32 << 10;  ///< Of one image, all masks together.
  static constexpr std::uint32_t kMaxPieces = 64;    ///< Of one image.

  [[nodiscard]] static std::size_t required_bytes(const MaskMailboxConfig& config);
  /// The arena is sized by required_bytes.
  MaskMailbox(const MaskMailboxConfig& config, Arena& arena);
  /// `ask` is called by the pipeline's thread for each request and must not wait. Set before the first frame.
  void on_request(std::function<void()> ask) { ask_ = std::move(ask); }

  // The pipeline's thread.
  void request(const RectifiedPair& pair) noexcept override;
  [[nodiscard]] const MaskSet* await(std::int64_t frame_index) noexcept override;

  // The network's thread.
  void offer(const MaskMessage& message) noexcept;
  /// The newest request that was not taken yet.
  [[nodiscard]] std::optional<MaskRequest> take_request() noexcept;
  /// While there are none, nobody is waited for.
  void set_senders(std::uint32_t senders) noexcept;

  // Any thread.

  /// False if no sender came in this time.
  [[nodiscard]] bool wait_for_sender(std::chrono::milliseconds at_most);
  [[nodiscard]] MaskCounters counters() const;

 private:
  struct ViewMasks {
    FixedVector<RunLengthMask> masks;
    FixedVector<std::uint16_t> runs;
    std::uint64_t pieces_seen = 0;  ///< One bit each.
    std::uint32_t pieces = 0;       ///< 0: none came yet.
    [[nodiscard]] bool is_whole() const noexcept;
    void clear() noexcept;
  };
  /// What one sender has sent for one frame.
  struct Slot {
    bool in_use = false;
    bool is_bad = false;  ///< Something of it was not valid; it will never be whole.
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
  /// All who could send have sent something for this frame that will never be whole.
  [[nodiscard]] bool is_given_up(std::int64_t frame_index) const noexcept;
  /// The message's slot, or a new one; null where there is no room. For the frame that is waited for there is, unless
  /// as many senders as there are slots have begun with it.
  [[nodiscard]] Slot* reserve_slot(const MaskMessage& message) noexcept;
  /// What makes room for the frame that is waited for: what is bad, else the frame farthest ahead; null if nothing
  /// does.
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
  std::optional<MaskRequest> awaited_;  ///< The newest frame that was asked for: older ones are over.
  std::uint32_t senders_ = 0;
  MaskCounters counters_;
  MaskSet taken_;  ///< Of the slot that the pipeline reads.
};

}  // namespace kinetrace::app
