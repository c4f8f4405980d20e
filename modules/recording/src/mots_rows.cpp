#include "mots_rows.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "kinetrace/imaging/mask_rle.hpp"

namespace kinetrace::recording {

std::int64_t mots_object_id(std::uint16_t class_id, std::uint32_t track_id) noexcept {
  return track_id < kMotsIdsPerClass ? class_id * kMotsIdsPerClass + track_id : kMotsLargeIds + track_id;
}

std::int64_t mots_track_id(std::int64_t class_id, std::int64_t object_id) noexcept {
  return object_id >= kMotsLargeIds ? object_id - kMotsLargeIds : object_id - class_id * kMotsIdsPerClass;
}

int MotsRows::append(const FrameResult& result, BufferedWriter& out) noexcept {
  decide(result.tracks);
  int written = 0;
  const LabelView labels = result.left_labels;
  for (const Track& track : result.tracks) {
    if (labels.empty() || track.mask_lost || !imaging::has_label(labels, track.box_px, track.label())) {
      continue;
    }
    const State state = track.state == TrackState::kTentative ? State::kTentative : State::kConfirmed;
    written += add({.frame = result.newest.frame_index,
                    .track_id = track.id,
                    .class_id = track.class_id,
                    .state = state,
                    .height_px = labels.height,
                    .width_px = labels.width},
                   labels, track, out);
  }
  return written + write_decided(out);
}

int MotsRows::finish(BufferedWriter& out) noexcept {
  decide({});
  return write_decided(out);
}

void MotsRows::decide(std::span<const Track> tracks) noexcept {
  for (Row& row : std::span(rows_).first(count_)) {
    if (row.state != State::kTentative) {
      continue;
    }
    const auto track =
        std::find_if(tracks.begin(), tracks.end(), [&](const Track& alive) { return alive.id == row.track_id; });
    if (track == tracks.end()) {
      row.state = State::kDropped;
    } else if (track->state != TrackState::kTentative) {
      row.state = State::kConfirmed;
    }
  }
}

int MotsRows::write_decided(BufferedWriter& out) noexcept {
  int written = 0;
  std::size_t begin = 0;
  std::size_t row = 0;
  for (; row < count_ && rows_[row].state != State::kTentative; ++row) {
    if (rows_[row].state == State::kConfirmed) {
      write_head(rows_[row], out);
      out.bytes(run_lengths_.subspan(begin, rows_[row].size)).text("\n");
      ++written;
    }
    begin += rows_[row].size;
  }
  std::move(rows_.begin() + row, rows_.begin() + count_, rows_.begin());
  std::ranges::move(run_lengths_.subspan(begin, used_ - begin), run_lengths_.begin());
  count_ -= row;
  used_ -= begin;
  return written;
}

int MotsRows::add(Row row, LabelView labels, const Track& track, BufferedWriter& out) noexcept {
  if (try_add(row, labels, track)) {
    return 0;
  }
  const int written = finish(out);  // full: those that still wait are dropped
  if (try_add(row, labels, track) || row.state == State::kTentative) {
    return written;
  }
  // Larger than the whole buffer.
  write_head(row, out);
  imaging::encode_mask_rle(labels, track.box_px, track.label(), [&out](std::string_view text) { out.text(text); });
  out.text("\n");
  return written + 1;
}

bool MotsRows::try_add(Row row, LabelView labels, const Track& track) noexcept {
  bool fits = count_ < rows_.size();
  imaging::encode_mask_rle(labels, track.box_px, track.label(), [&](std::string_view text) {
    fits = fits && used_ + row.size + text.size() <= run_lengths_.size();
    if (fits) {
      std::memcpy(run_lengths_.data() + used_ + row.size, text.data(), text.size());
      row.size += text.size();
    }
  });
  if (fits) {
    rows_[count_++] = row;
    used_ += row.size;
  }
  return fits;
}

void MotsRows::write_head(const Row& row, BufferedWriter& out) noexcept {
  out.integer(row.frame).text(" ").integer(mots_object_id(row.class_id, row.track_id)).text(" ");
  out.integer(row.class_id).text(" ").integer(row.height_px).text(" ").integer(row.width_px).text(" ");
}

}  // namespace kinetrace::recording
