#include "run_observations.hpp"

namespace kinetrace::batch {

Result<RunObservations> RunObservations::open(const recording::Run& run, const MeasuredBackground& measured) {
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  if (!reader) {
    return Unexpected(reader.error());
  }
  return RunObservations(std::move(*reader), run.rectified, measured);
}

Result<std::span<const recording::Observation>> RunObservations::next_frame() {
  Result<std::span<const recording::Observation>> seen = reader_.next_frame();
  if (!seen || seen->empty()) {
    return seen;
  }
  const auto background = measured_->frames.find(seen->front().frame);
  if (background == measured_->frames.end()) {
    return seen;
  }
  frame_ = background->second;
  const DisparityChange change = measured_->change_in(seen->front().frame);
  for (recording::Observation each : *seen) {
    if (each.track_id != 0) {
      each.u_right_px -= static_cast<float>(change.at(geometry_, each.u_left_px, each.v_px));
      frame_.push_back(each);
    }
  }
  return std::span<const recording::Observation>(frame_);
}

}  // namespace kinetrace::batch
