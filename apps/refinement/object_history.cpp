#include "object_history.hpp"

#include <unordered_map>

#include "kinetrace/recording/mask_frames.hpp"
#include "run_observations.hpp"

namespace kinetrace::batch {

namespace {

/// With the disparity corrected for the right camera's pose that was used to measure the background again.
recording::ObjectRow revised(const recording::ObjectRow& object, const Se3& T_world_cam, const StereoGeometry& geometry,
                             const DisparityChange& change) {
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * object.T_world_obj.translation;
  if (change.is_zero() || !(p_cam.z() > 0.0)) {
    return object;
  }
  const Eigen::Vector3d px = geometry.project(p_cam);
  const double disparity_px = px.x() - px.z();
  const double revised_px = disparity_px + change.at(geometry, px.x(), px.y());
  recording::ObjectRow result = object;
  if (revised_px > 0.5 * disparity_px) {
    result.T_world_obj.translation = T_world_cam * (p_cam * (disparity_px / revised_px));
  }
  return result;
}

}  // namespace

Result<std::map<std::uint32_t, ObjectHistory>> object_histories(const recording::Run& run,
                                                                const MeasuredBackground& measured) {
  std::map<std::uint32_t, ObjectHistory> histories;
  std::unordered_map<std::int64_t, std::size_t> rows;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    rows.emplace(run.camera[row].frame, row);
  }
  for (const recording::ObjectRow& object : run.objects) {
    if (const auto row = rows.find(object.frame); row != rows.end()) {
      histories[object.track_id].track_id = object.track_id;
      histories[object.track_id].rows.emplace(row->second, revised(object, run.camera[row->second].T_world_cam,
                                                                   run.rectified, measured.change_in(object.frame)));
    }
  }
  Result<RunObservations> reader = RunObservations::open(run, measured);
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
