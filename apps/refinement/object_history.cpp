#include "object_history.hpp"

#include <unordered_map>

#include "kinetrace/recording/mask_frames.hpp"
#include "kinetrace/recording/observations.hpp"

namespace kinetrace::batch {

Result<std::map<std::uint32_t, ObjectHistory>> object_histories(const recording::Run& run) {
  std::map<std::uint32_t, ObjectHistory> histories;
  std::unordered_map<std::int64_t, std::size_t> rows;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    rows.emplace(run.camera[row].frame, row);
  }
  for (const recording::ObjectRow& object : run.objects) {
    if (const auto row = rows.find(object.frame); row != rows.end()) {
      histories[object.track_id].track_id = object.track_id;
      histories[object.track_id].rows.emplace(row->second, object);
    }
  }
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  if (!reader) {
    return Unexpected(reader.error());
  }
  while (true) {
    const Result<std::span<const recording::Observation>> frame = reader->next_frame();
    if (!frame) {
      return Unexpected(frame.error());
    }
    if (frame->empty()) {
      return histories;
    }
    const auto row = rows.find(frame->front().frame);
    for (const recording::Observation& seen : *frame) {
      const auto history = histories.find(seen.track_id);
      if (row != rows.end() && history != histories.end()) {
        history->second.seen[row->second].push_back(
            {static_cast<std::uint32_t>(row->second), seen.point_id, {seen.u_left_px, seen.v_px, seen.u_right_px}});
      }
    }
  }
}

Result<std::map<std::uint32_t, std::map<std::size_t, PixelBox>>> object_masks(const recording::Run& run) {
  Result<recording::MaskFrames> frames = recording::MaskFrames::open(run);
  if (!frames) {
    return Unexpected(frames.error());
  }
  std::map<std::uint32_t, std::map<std::size_t, PixelBox>> masks_px;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    const Result<recording::MaskFrame> frame = frames->at(run.camera[row].frame);
    if (!frame) {
      return Unexpected(frame.error());
    }
    for (const recording::FrameMask& mask : frame->masks) {
      masks_px[mask.track_id].emplace(row, mask.box_px);
    }
  }
  return masks_px;
}

}  // namespace kinetrace::batch
