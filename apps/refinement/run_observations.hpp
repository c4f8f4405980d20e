// A run's observations for refinement.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "kinetrace/recording/observations.hpp"
#include "measurement/background_measurement.hpp"

namespace kinetrace::batch {

/// Observations of the background as measured again, and of objects with disparities corrected for the same right
/// camera. Holds one frame.
class RunObservations {
 public:
  /// `measured` must outlive it. Errors: those of ObservationReader.
  [[nodiscard]] static Result<RunObservations> open(const recording::Run& run, const MeasuredBackground& measured);

  /// As ObservationReader::next_frame.
  [[nodiscard]] Result<std::span<const recording::Observation>> next_frame();

 private:
  RunObservations(recording::ObservationReader reader, const StereoGeometry& geometry,
                  const MeasuredBackground& measured)
      : reader_(std::move(reader)), geometry_(geometry), measured_(&measured) {}

  recording::ObservationReader reader_;
  StereoGeometry geometry_;
  const MeasuredBackground* measured_;
  std::vector<recording::Observation> frame_;
};

}  // namespace kinetrace::batch
