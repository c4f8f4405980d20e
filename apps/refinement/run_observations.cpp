#include "run_observations.hpp"

#include <algorithm>
#include <iterator>

namespace kinetrace::batch {

Result<RunObservations> RunObservations::open(const recording::Run& run, const MeasuredBackground& measured) {
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  if (!reader) {
    return Unexpected(reader.error());
  }
  return RunObservations(std::move(*reader), measured);
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
  std::copy_if(seen->begin(), seen->end(), std::back_inserter(frame_),
               [](const recording::Observation& each) { return each.track_id != 0; });
  return std::span<const recording::Observation>(frame_);
}

}  // namespace kinetrace::batch
