// Tracks of a made-up rig through a made-up world, with known truth.
#pragma once

#include <cstddef>
#include <vector>

#include "rig_model.hpp"
#include "track_window.hpp"

namespace kinetrace::self_calibration::test {

enum class Motion { kTravel, kTurn, kRest };
enum class World { kDeep, kWall };

struct DriveOptions {
  Motion motion = Motion::kTravel;
  World world = World::kDeep;
  std::size_t windows = 4;
  std::size_t frames = 8;  ///< Of a window.
  std::size_t points = 150;
  double noise_px = 0.05;
  double outlier_share = 0.0;  ///< Share of tracks on moving points.
};

/// Two lenses and a mount, all with small errors.
[[nodiscard]] RigModel distorted_rig();

/// The same tracks in every call.
[[nodiscard]] std::vector<TrackWindow> synthetic_drive(const RigModel& rig, const DriveOptions& options);

}  // namespace kinetrace::self_calibration::test
