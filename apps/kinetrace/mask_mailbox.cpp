#include "mask_mailbox.hpp"

#include <algorithm>

namespace kinetrace::app {

bool MaskMailbox::Eyeful::is_whole() const noexcept {
  return pieces > 0 && pieces_seen == (~std::uint64_t{0} >> (kMaxPieces - pieces));
}

void MaskMailbox::Eyeful::clear() noexcept {
  masks.clear();
  runs.clear();
  pieces_seen = 0;
  pieces = 0;
}

void MaskMailbox::carve(const MaskMailboxConfig& config, Arena& arena, Slots& slots) {
  for (Slot& slot : slots) {
    for (std::size_t eye = 0; eye < (config.right ? 2U : 1U); ++eye) {
      slot.eyes[eye].masks = FixedVector<RunLengthMask>(arena, kMaxMasks);
      slot.eyes[eye].runs = FixedVector<std::uint16_t>(arena, kMaxRuns);
    }
  }
}

std::size_t MaskMailbox::required_bytes(const MaskMailboxConfig& config) {
  return measure_bytes([&](Arena& arena) {
    Slots slots;
    carve(config, arena, slots);
  });
}

MaskMailbox::MaskMailbox(const MaskMailboxConfig& config, Arena& arena) : config_(config) {
  carve(config, arena, slots_);
}

void MaskMailbox::request(const RectifiedPair& pair) noexcept {
  {
    const std::lock_guard lock(mutex_);
    request_ = {pair.frame_index, pair.timestamp_ns, static_cast<std::uint32_t>(config_.width_px),
                static_cast<std::uint32_t>(config_.height_px), config_.right};
    awaited_ = pair.frame_index;
    // What the pipeline left out, and what it read last, makes room.
    for (Slot& slot : slots_) {
      slot.in_use = slot.in_use && slot.frame_index >= pair.frame_index;
    }
  }
  if (ask_) {
    ask_();
  }
}

const MaskSet* MaskMailbox::await(std::int64_t frame_index) noexcept {
  std::unique_lock lock(mutex_);
  const auto is_decided = [&] {
    const Slot* slot = find(frame_index);
    return senders_ == 0 || (slot != nullptr && (slot->is_bad || is_whole(*slot)));
  };
  const bool in_time = changed_.wait_for(lock, config_.timeout, is_decided);
  const Slot* slot = find(frame_index);
  if (slot != nullptr && is_whole(*slot)) {
    ++counters_.frames_taken;
    taken_ = {slot->eyes[0].masks.span(), slot->eyes[1].masks.span()};
    return &taken_;
  }
  ++(in_time && senders_ == 0 ? counters_.frames_unsent : counters_.frames_timed_out);
  return nullptr;
}

bool MaskMailbox::is_valid(const MaskMessage& message) const noexcept {
  const bool is_expected = message.width_px == static_cast<std::uint32_t>(config_.width_px) &&
                           message.height_px == static_cast<std::uint32_t>(config_.height_px) &&
                           (message.eye == Eye::kLeft || config_.right) && message.pieces >= 1 &&
                           message.pieces <= kMaxPieces && message.piece < message.pieces;
  return is_expected && std::all_of(message.masks.begin(), message.masks.end(), [this](const RunLengthMask& mask) {
           return fits(mask, config_.width_px, config_.height_px);
         });
}

bool MaskMailbox::is_whole(const Slot& slot) const noexcept {
  return !slot.is_bad && slot.eyes[0].is_whole() && (!config_.right || slot.eyes[1].is_whole());
}

MaskMailbox::Slot* MaskMailbox::find(std::int64_t frame_index) noexcept {
  auto* slot = std::find_if(slots_.begin(), slots_.end(),
                            [&](const Slot& s) { return s.in_use && s.frame_index == frame_index; });
  return slot == slots_.end() ? nullptr : slot;
}

MaskMailbox::Slot* MaskMailbox::claim(std::int64_t frame_index) noexcept {
  if (Slot* known = find(frame_index)) {
    return known;
  }
  // A slot is kept for the frame that the pipeline waits for, whatever comes ahead of it.
  const bool is_awaited = awaited_ == frame_index;
  const bool awaited_has_one = awaited_ && find(*awaited_) != nullptr;
  const auto free = std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.in_use; });
  if (free == 0 || (free == 1 && !is_awaited && !awaited_has_one)) {
    return nullptr;
  }
  Slot& slot = *std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.in_use; });
  slot.in_use = true;
  slot.is_bad = false;
  slot.frame_index = frame_index;
  for (Eyeful& eye : slot.eyes) {
    eye.clear();
  }
  return &slot;
}

// False if it contradicts what came before, or there is no room for all of it.
bool MaskMailbox::store(const MaskMessage& message, Eyeful& eye) noexcept {
  if (eye.pieces != 0 && eye.pieces != message.pieces) {
    return false;
  }
  eye.pieces = message.pieces;
  const std::uint64_t bit = std::uint64_t{1} << message.piece;
  if ((eye.pieces_seen & bit) != 0) {
    return true;  // Sent twice.
  }
  eye.pieces_seen |= bit;
  for (const RunLengthMask& mask : message.masks) {
    const std::size_t first = eye.runs.size();
    if (eye.masks.full() || mask.runs.size() > eye.runs.capacity() - first) {
      return false;
    }
    for (const std::uint16_t run : mask.runs) {
      static_cast<void>(eye.runs.push_back(run));
    }
    RunLengthMask kept = mask;
    kept.runs = eye.runs.span().subspan(first);
    static_cast<void>(eye.masks.push_back(kept));
  }
  return true;
}

void MaskMailbox::offer(const MaskMessage& message) noexcept {
  {
    const std::lock_guard lock(mutex_);
    ++counters_.messages;
    if (awaited_ && message.frame_index < *awaited_) {
      ++counters_.messages_late;
      return;
    }
    Slot* slot = claim(message.frame_index);
    if (slot == nullptr) {
      ++counters_.messages_early;
      return;
    }
    if (slot->is_bad || is_whole(*slot)) {
      return;  // Decided; the pipeline may be reading it.
    }
    if (!is_valid(message) || !store(message, slot->eyes[message.eye == Eye::kLeft ? 0 : 1])) {
      ++counters_.messages_invalid;
      slot->is_bad = true;
    }
  }
  changed_.notify_all();
}

std::optional<MaskRequest> MaskMailbox::take_request() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(request_, std::nullopt);
}

void MaskMailbox::set_senders(std::uint32_t senders) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (senders_ == senders) {
      return;
    }
    senders_ = senders;
  }
  changed_.notify_all();
}

bool MaskMailbox::wait_for_sender(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, at_most, [this] { return senders_ > 0; });
}

MaskCounters MaskMailbox::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace kinetrace::app
