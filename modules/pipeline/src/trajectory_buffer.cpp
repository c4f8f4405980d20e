#include "trajectory_buffer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::pipeline {
namespace {

/// The object in the frame after this one; null if there is none.
BufferedObject* after(ResultRing& ring, std::uint32_t track_id, std::size_t age) {
  return age > 0 ? ring.frame(age - 1).find(track_id) : nullptr;
}

/// The age of the path's oldest frame.
std::size_t beginning_of(ResultRing& ring, std::uint32_t track_id, std::size_t age) {
  while (ring.frame(age).find(track_id)->change == FrameChange::kNone && age + 1 < ring.size() &&
         ring.frame(age + 1).find(track_id) != nullptr) {
    ++age;
  }
  return age;
}

/// The age of the newest frame that refers to the same point.
std::size_t newest_of_point(ResultRing& ring, std::uint32_t track_id, std::size_t age) {
  for (const BufferedObject* next = after(ring, track_id, age);
       next != nullptr && next->change != FrameChange::kReplaced; next = after(ring, track_id, age)) {
    --age;
  }
  return age;
}

/// Without a reconstruction, poses of successive frames have almost the same error (first-order Gauss-Markov): this
/// many of them count as one that is independent.
double samples_per_correlation_time(std::int64_t interval_ns) {
  return interval_ns <= 0 ? 1.0 : 1.0 / std::tanh(0.5e-9 * static_cast<double>(interval_ns) / kErrorCorrelation_s);
}

}  // namespace

TrajectoryBuffer::TrajectoryBuffer(const trajectory::TrajectoryConfig& config, std::size_t frames, Arena& arena)
    : smoother_(config, frames, arena), nodes_(arena.take<trajectory::PathNode>(frames)) {}

bool TrajectoryBuffer::ends_at(ResultRing& ring, std::uint32_t track_id, std::size_t age) noexcept {
  const BufferedObject* const next = after(ring, track_id, age);
  return next == nullptr || next->change != FrameChange::kNone;
}

std::optional<PathEnd> TrajectoryBuffer::smooth(ResultRing& ring, std::size_t pending, std::uint32_t track_id,
                                                std::size_t age, const PathObject& object) noexcept {
  const std::size_t end_age = beginning_of(ring, track_id, age) + 1;
  const std::span<trajectory::PathNode> path = nodes_.first(end_age - newest_of_point(ring, track_id, age));
  const std::int64_t duration_ns =
      ring.frame(end_age - path.size()).timestamp_ns - ring.frame(end_age - 1).timestamp_ns;
  const std::int64_t interval_ns = duration_ns / std::max<std::int64_t>(static_cast<std::int64_t>(path.size()) - 1, 1);
  const std::size_t finalised = end_age > pending ? end_age - pending : 0;
  // Fixed poses that are uncertain would keep their error: later ones, each with little weight, hardly change the path.
  // A smoothed pose instead counts as one measurement, since it contains those before it.
  const std::size_t fixed = object.reconstructed ? finalised : 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const BufferedFrame& kept = ring.frame(end_age - 1 - i);
    const ObjectResult& result = kept.find(track_id)->result;
    path[i] = {kept.timestamp_ns, result.T_world_obj, result.covariance, result.T_world_obj};
    if (result.status != BodyStatus::kTracked && i >= finalised) {
      path[i].covariance *= samples_per_correlation_time(interval_ns);
    }
  }
  smoother_.smooth(path, fixed, object.prior);
  for (std::size_t i = finalised; i < end_age - age; ++i) {
    ring.frame(end_age - 1 - i).find(track_id)->result.T_world_obj = path[i].smoothed;
  }
  if (age > 0 || path.size() < kMinPathFrames) {
    return std::nullopt;
  }
  return PathEnd{path.back().smoothed, trajectory::body_velocity(path[path.size() - 2], path.back())};
}

}  // namespace kinetrace::pipeline
