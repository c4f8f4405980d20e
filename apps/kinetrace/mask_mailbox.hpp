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
  std::uint64_t frames_taken = 0;      ///< Whole, and in time.
  std::uint64_t frames_timed_out = 0;  ///< Waited for in vain.
  std::uint64_t frames_unsent = 0;     ///< Not waited for, since nobody is there who could send any.
  std::uint64_t messages = 0;          ///< Received.
  std::uint64_t messages_late = 0;     ///< Of these: of a frame that is over ...
  std::uint64_t messages_early = 0;    ///< ... of one so far ahead that there is no room ...
  std::uint64_t messages_invalid = 0;  ///< ... or not what they should be: size, eye, pieces, run lengths, amount.
};

/// Holds masks of a few frames, each whole only with all its pieces, until the pipeline asks. One thread offers, one
/// awaits. All memory is taken at the start. What arrives is checked here: nothing that a network brings is believed.
class MaskMailbox final : public MaskSource {
 public:
  static constexpr std::size_t kFrames = 4;          ///< That may be under way at once.
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
  struct Eyeful {
    FixedVector<RunLengthMask> masks;
    FixedVector<std::uint16_t> runs;
    std::uint64_t pieces_seen = 0;  ///< One bit each.
    std::uint32_t pieces = 0;       ///< 0: none came yet.
    [[nodiscard]] bool is_whole() const noexcept;
    void clear() noexcept;
  };
  struct Slot {
    bool in_use = false;
    bool is_bad = false;  ///< Something of this frame was not valid; it will never be whole.
    std::int64_t frame_index = 0;
    std::array<Eyeful, 2> eyes;
  };

  using Slots = std::array<Slot, kFrames>;

  static void carve(const MaskMailboxConfig& config, Arena& arena, Slots& slots);
  [[nodiscard]] bool is_valid(const MaskMessage& message) const noexcept;
  [[nodiscard]] bool is_whole(const Slot& slot) const noexcept;
  [[nodiscard]] Slot* find(std::int64_t frame_index) noexcept;
  [[nodiscard]] Slot* claim(std::int64_t frame_index) noexcept;
  [[nodiscard]] static bool store(const MaskMessage& message, Eyeful& eye) noexcept;

  const MaskMailboxConfig config_;
  std::function<void()> ask_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // All guarded by the mutex.
  Slots slots_;
  std::optional<MaskRequest> request_;
  std::optional<std::int64_t> awaited_;  ///< The newest frame that was asked for: older ones are over.
  std::uint32_t senders_ = 0;
  MaskCounters counters_;
  MaskSet taken_;  ///< Of the slot that the pipeline reads.
};

}  // namespace kinetrace::app
