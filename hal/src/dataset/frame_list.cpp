#include "kinetrace/hal/frame_list.hpp"

#include <algorithm>

#include "kinetrace/core/quantiles.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {

Status FrameList::add(const Frame& frame) {
  if (!holds(frame.frame_index, frame.timestamp_ns)) {
    return fail(ErrorCode::kBadFormat,
                concat(times_source_, ": frame ", frame.name(), " has the number ", std::to_string(frame.frame_index),
                       " and the time ", std::to_string(frame.timestamp_ns), " ns; numbers must be in [0, ",
                       std::to_string(kMaxFrameIndex), "] and times before 2116"));
  }
  if (!entries_.empty()) {
    const Entry& last = entries_.back();
    if (frame.frame_index <= last.frame_index || frame.timestamp_ns <= last.timestamp_ns) {
      return fail(ErrorCode::kBadFormat,
                  concat(times_source_, ": frame ", frame.name(), " does not come after the one before it (time ",
                         std::to_string(frame.timestamp_ns), " ns after ", std::to_string(last.timestamp_ns),
                         " ns); correct the time stamps"));
    }
  }
  if (stems_.size() + frame.left_stem.size() + frame.right_stem.size() + 2 >= kNoStem) {
    return fail(ErrorCode::kCapacity, left_.folder + ": more file names than a recording can hold; split it");
  }
  Entry entry{frame.frame_index, frame.timestamp_ns, kNoStem, kNoStem};
  entry.left_stem = store(frame.left_stem);
  entry.right_stem = frame.right_stem == frame.left_stem ? entry.left_stem : store(frame.right_stem);
  entries_.push_back(entry);
  return {};
}

FrameList::Frame FrameList::operator[](std::size_t i) const noexcept {
  const Entry& entry = entries_[i];
  return {entry.frame_index, entry.timestamp_ns, stem_at(entry.left_stem), stem_at(entry.right_stem)};
}

std::size_t FrameList::complete_count() const noexcept {
  return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(), [](const Entry& entry) {
    return entry.left_stem != kNoStem && entry.right_stem != kNoStem;
  }));
}

std::int64_t FrameList::median_period_ns(std::int64_t fallback_ns) const {
  if (entries_.size() < 2) {
    return fallback_ns;
  }
  std::vector<std::int64_t> periods;
  periods.reserve(entries_.size() - 1);
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    periods.push_back((entries_[i].timestamp_ns - entries_[i - 1].timestamp_ns) /
                      (entries_[i].frame_index - entries_[i - 1].frame_index));
  }
  return std::max<std::int64_t>(median(periods), 1);
}

std::size_t FrameList::longest_path() const noexcept {
  const auto length = [this](const FrameFolder& side) {
    return side.folder.size() + 1 + longest_stem_ + side.suffix.size();
  };
  return std::max(length(left_), length(right_));
}

std::uint32_t FrameList::store(std::string_view stem) {
  if (stem.empty()) {
    return kNoStem;
  }
  const auto offset = static_cast<std::uint32_t>(stems_.size());
  stems_.append(stem).push_back('\0');
  longest_stem_ = std::max(longest_stem_, stem.size());
  return offset;
}

std::string_view FrameList::stem_at(std::uint32_t offset) const noexcept {
  return offset == kNoStem ? std::string_view{} : std::string_view(stems_.data() + offset);
}

}  // namespace kinetrace::hal
