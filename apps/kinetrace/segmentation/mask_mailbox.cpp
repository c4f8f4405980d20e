#include "segmentation/mask_mailbox.hpp"

#include <algorithm>

namespace kinetrace::app {

bool MaskMailbox::ViewMasks::is_whole() const noexcept {
  return pieces > 0 && pieces_seen == (~std::uint64_t{0} >> (kMaxPieces - pieces));
}

void MaskMailbox::ViewMasks::clear() noexcept {
  masks.clear();
  runs.clear();
  pieces_seen = 0;
  pieces = 0;
}

bool MaskMailbox::Slot::is_of(const MaskMessage& message) const noexcept {
  return in_use && sender == message.sender && frame_index == message.frame_index &&
         timestamp_ns == message.timestamp_ns;
}

void MaskMailbox::carve(const MaskMailboxConfig& config, Arena& arena, Slots& slots) {
  for (Slot& slot : slots) {
    for (std::size_t view = 0; view < (config.right ? 2U : 1U); ++view) {
      slot.views[view].masks = FixedVector<RunLengthMask>(arena, kMaxMasks);
      slot.views[view].runs = FixedVector<std::uint16_t>(arena, kMaxRuns);
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
    awaited_ = request_;
    release_for(pair);
  }
  if (ask_) {
    ask_();
  }
}

void MaskMailbox::release_for(const RectifiedPair& pair) noexcept {
  for (Slot& slot : slots_) {
    const bool is_of_other_run =
        slot.in_use && slot.frame_index == pair.frame_index && slot.timestamp_ns != pair.timestamp_ns;
    counters_.messages_of_other_run += is_of_other_run ? slot.messages : 0;
    // Releases skipped frames and the frame read last.
    slot.in_use = slot.in_use && slot.frame_index >= pair.frame_index && !is_of_other_run;
  }
}

const MaskSet* MaskMailbox::await(std::int64_t frame_index) noexcept {
  std::unique_lock lock(mutex_);
  const auto is_decided = [&] {
    return senders_ == 0 || find_whole(frame_index) != nullptr || is_given_up(frame_index);
  };
  const bool in_time = changed_.wait_for(lock, config_.timeout, is_decided);
  if (const Slot* slot = find_whole(frame_index)) {
    ++counters_.frames_taken;
    taken_ = {slot->views[0].masks.span(), slot->views[1].masks.span()};
    return &taken_;
  }
  ++(in_time && senders_ == 0 ? counters_.frames_unsent : counters_.frames_timed_out);
  return nullptr;
}

bool MaskMailbox::is_valid(const MaskMessage& message) const noexcept {
  const bool is_expected = message.width_px == static_cast<std::uint32_t>(config_.width_px) &&
                           message.height_px == static_cast<std::uint32_t>(config_.height_px) &&
                           (message.view == View::kLeft || config_.right) && message.pieces >= 1 &&
                           message.pieces <= kMaxPieces && message.piece < message.pieces;
  return is_expected && std::all_of(message.masks.begin(), message.masks.end(), [this](const RunLengthMask& mask) {
           return fits(mask, config_.width_px, config_.height_px);
         });
}

bool MaskMailbox::is_whole(const Slot& slot) const noexcept {
  return !slot.is_bad && slot.views[0].is_whole() && (!config_.right || slot.views[1].is_whole());
}

const MaskMailbox::Slot* MaskMailbox::find_whole(std::int64_t frame_index) const noexcept {
  const auto* slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) {
    return s.in_use && s.frame_index == frame_index && is_whole(s);
  });
  return slot == slots_.end() ? nullptr : slot;
}

bool MaskMailbox::is_given_up(std::int64_t frame_index) const noexcept {
  const auto bad = std::count_if(slots_.begin(), slots_.end(),
                                 [&](const Slot& s) { return s.in_use && s.frame_index == frame_index && s.is_bad; });
  return bad >= std::int64_t{senders_};
}

MaskMailbox::Slot* MaskMailbox::dispensable() noexcept {
  Slot* found = nullptr;
  for (Slot& slot : slots_) {
    if (slot.is_bad) {
      return &slot;
    }
    const bool is_ahead = slot.frame_index != awaited_->frame_index;
    if (is_ahead && (found == nullptr || slot.frame_index > found->frame_index)) {
      found = &slot;
    }
  }
  return found;
}

MaskMailbox::Slot* MaskMailbox::reserve_slot(const MaskMessage& message) noexcept {
  const auto first = [this](auto&& condition) {
    auto* slot = std::find_if(slots_.begin(), slots_.end(), condition);
    return slot == slots_.end() ? nullptr : slot;
  };
  if (Slot* known = first([&](const Slot& s) { return s.is_of(message); })) {
    return known;
  }
  Slot* slot = first([](const Slot& s) { return !s.in_use; });
  if (slot == nullptr && awaited_ && awaited_->frame_index == message.frame_index) {
    slot = dispensable();
    counters_.messages_early += slot != nullptr && !slot->is_bad ? slot->messages : 0;
  }
  if (slot == nullptr) {
    return nullptr;
  }
  slot->in_use = true;
  slot->is_bad = false;
  slot->sender = message.sender;
  slot->frame_index = message.frame_index;
  slot->timestamp_ns = message.timestamp_ns;
  slot->messages = 0;
  for (ViewMasks& view : slot->views) {
    view.clear();
  }
  return slot;
}

// False if the message contradicts earlier pieces, or exceeds the capacity.
bool MaskMailbox::store(const MaskMessage& message, ViewMasks& view) noexcept {
  if (view.pieces != 0 && view.pieces != message.pieces) {
    return false;
  }
  view.pieces = message.pieces;
  const std::uint64_t bit = std::uint64_t{1} << message.piece;
  if ((view.pieces_seen & bit) != 0) {
    return true;  // Sent twice.
  }
  view.pieces_seen |= bit;
  for (const RunLengthMask& mask : message.masks) {
    const std::size_t first = view.runs.size();
    if (view.masks.full() || mask.runs.size() > view.runs.capacity() - first) {
      return false;
    }
    for (const std::uint16_t run : mask.runs) {
      static_cast<void>(view.runs.push_back(run));
    }
    RunLengthMask kept = mask;
    kept.runs = view.runs.span().subspan(first);
    static_cast<void>(view.masks.push_back(kept));
  }
  return true;
}

void MaskMailbox::offer(const MaskMessage& message) noexcept {
  {
    const std::lock_guard lock(mutex_);
    ++counters_.messages;
    if (awaited_ && message.frame_index < awaited_->frame_index) {
      ++counters_.messages_late;
      return;
    }
    if (awaited_ && message.frame_index == awaited_->frame_index && message.timestamp_ns != awaited_->timestamp_ns) {
      ++counters_.messages_of_other_run;
      return;
    }
    Slot* slot = reserve_slot(message);
    if (slot == nullptr) {
      ++counters_.messages_early;
      return;
    }
    ++slot->messages;
    if (slot->is_bad || is_whole(*slot)) {
      return;  // Complete or rejected; the pipeline may be reading it.
    }
    if (!is_valid(message) || !store(message, slot->views[message.view == View::kLeft ? 0 : 1])) {
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
