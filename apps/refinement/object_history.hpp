// A run's data on each object over its life.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "body_adjustment.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"
#include "measurement/background_measurement.hpp"

namespace kinetrace::batch {

struct ObjectHistory {
  std::uint32_t track_id = 0;
  std::map<std::size_t, recording::ObjectRow> rows;    ///< By row of Run::camera.
  std::map<std::size_t, std::vector<SeenPoint>> seen;  ///< Likewise; SeenPoint::frame is that row.
};

/// By track; disparities, also those of positions, as in RunObservations. Errors: those of ObservationReader.
[[nodiscard]] Result<std::map<std::uint32_t, ObjectHistory>> object_histories(const recording::Run& run,
                                                                              const MeasuredBackground& measured = {});

/// Boxes of the masks of each track, by row of Run::camera. Errors: those of MaskFrames.
[[nodiscard]] Result<std::map<std::uint32_t, std::map<std::size_t, PixelBox>>> object_masks(const recording::Run& run);

}  // namespace kinetrace::batch
