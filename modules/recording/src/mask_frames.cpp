#include "kinetrace/recording/mask_frames.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "kinetrace/imaging/mask_rle.hpp"

namespace kinetrace::recording {

Result<MaskFrames> MaskFrames::open(const Run& run) {
  Result<std::vector<MaskRow>> rows = read_masks(run);
  if (!rows) {
    return Unexpected(rows.error());
  }
  MaskFrames frames;
  frames.path_ = run.directory / "mots.txt";
  frames.rows_ = std::move(*rows);
  if (frames.rows_.empty()) {
    return frames;
  }
  frames.width_ = frames.rows_.front().width_px;
  frames.height_ = frames.rows_.front().height_px;
  for (const MaskRow& row : frames.rows_) {
    if (row.width_px != frames.width_ || row.height_px != frames.height_) {
      return frames.damaged(row,
                            "an image of " + std::to_string(row.width_px) + " x " + std::to_string(row.height_px) +
                                " pixels, not " + std::to_string(frames.width_) + " x " +
                                std::to_string(frames.height_) + " as before",
                            ErrorCode::kBadFormat);
    }
  }
  frames.labels_.resize(static_cast<std::size_t>(frames.width_) * static_cast<std::size_t>(frames.height_));
  return frames;
}

Result<MaskFrame> MaskFrames::at(std::int64_t frame) {
  std::fill(labels_.begin(), labels_.end(), kBackgroundLabel);
  masks_.clear();
  const auto by_frame = [](const MaskRow& row, std::int64_t number) { return row.frame < number; };
  const auto first = std::lower_bound(rows_.begin(), rows_.end(), frame, by_frame);
  for (auto row = first; row != rows_.end() && row->frame == frame; ++row) {
    if (const Status painted = paint(*row); !painted) {
      return Unexpected(painted.error());
    }
  }
  return MaskFrame{{labels_.data(), width_, height_, width_}, masks_};
}

Status MaskFrames::paint(const MaskRow& row) {
  if (masks_.size() == kMaxMasksPerFrame) {
    return damaged(row, std::string("more than ").append(std::to_string(kMaxMasksPerFrame)).append(" masks"),
                   ErrorCode::kCapacity);
  }
  if (std::any_of(masks_.begin(), masks_.end(), [&](const FrameMask& mask) { return mask.track_id == row.track_id; })) {
    return damaged(row, "has two masks", ErrorCode::kBadFormat);
  }
  const Result<std::vector<imaging::MaskRun>> runs = imaging::decode_mask_rle(row.rle, width_, height_);
  if (!runs) {
    return damaged(row, runs.error().message, runs.error().code);
  }
  FrameMask mask{static_cast<std::uint8_t>(masks_.size() + 1), row.track_id, row.class_id, {}, 0};
  for (const imaging::MaskRun& run : *runs) {
    for (std::int64_t position = run.begin; position < run.end; ++position) {
      const int x = static_cast<int>(position / height_);
      const int y = static_cast<int>(position % height_);
      std::uint8_t& pixel = labels_[static_cast<std::size_t>(std::int64_t{y} * width_ + x)];
      if (pixel != kBackgroundLabel) {
        return damaged(row, "covers pixels of another mask", ErrorCode::kBadFormat);
      }
      pixel = mask.label;
      mask.box_px.include(x, y);
    }
    mask.area_px += run.end - run.begin;
  }
  masks_.push_back(mask);
  return {};
}

Unexpected<Error> MaskFrames::damaged(const MaskRow& row, const std::string& reason, ErrorCode code) const {
  return fail(code, path_.string() + ", frame " + std::to_string(row.frame) + ", track " +
                        std::to_string(row.track_id) + ": " + reason);
}

}  // namespace kinetrace::recording
