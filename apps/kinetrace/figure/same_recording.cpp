#include "figure/same_recording.hpp"

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kinetrace/features/affine_template.hpp"
#include "kinetrace/recording/common_times.hpp"
#include "kinetrace/recording/observations.hpp"

namespace kinetrace::figure {
namespace {

using features::AffineTemplate;
using recording::Observation;

// Of the run's points, 50 % or more are found in its own recording (512 pixels wide; 80 to 95 % from 640 pixels on), 5
// % or less in another one of the same rig and kind of world: rendered street, drone and wearable, KITTI raw and
// odometry.
constexpr double kMinShare = 0.15;
constexpr std::size_t kMinPoints = 30;
constexpr std::size_t kSamples = 5;
constexpr std::size_t kPointsOfSample = 100;
constexpr int kFramesApart = 2;  // In neighbouring frames a slow camera's points hardly move.
constexpr features::AffineGate kGate{.reach_px = 0.5, .correlation = 0.9};
constexpr double kPatchSigma_px = 3.0;

/// Background points in two left images.
struct Sample {
  std::int64_t first_frame = 0;
  std::int64_t later_frame = 0;
  std::vector<Eigen::Vector2d> first_px;
  std::vector<Eigen::Vector2d> later_px;
};

Sample seen_in_both(const std::vector<Observation>& first, std::span<const Observation> later) {
  std::unordered_map<std::uint32_t, const Observation*> by_id;
  for (const Observation& seen : first) {
    if (seen.track_id == 0) {
      by_id.emplace(seen.point_id, &seen);
    }
  }
  Sample sample{first.front().frame, later.front().frame, {}, {}};
  for (const Observation& seen : later) {
    const auto before = by_id.find(seen.point_id);
    if (seen.track_id == 0 && before != by_id.end() && sample.first_px.size() < kPointsOfSample) {
      sample.first_px.emplace_back(before->second->u_left_px, before->second->v_px);
      sample.later_px.emplace_back(seen.u_left_px, seen.v_px);
    }
  }
  return sample;
}

/// Spread over the run; none without observations.
std::vector<Sample> samples_of(const recording::Run& run) {
  std::vector<Sample> samples;
  Result<recording::ObservationReader> reader = recording::ObservationReader::open(run);
  std::vector<Observation> first;
  int later = 0;
  while (reader && samples.size() < kSamples) {
    const Result<std::span<const Observation>> seen = reader->next_frame();
    if (!seen || seen->empty()) {
      break;
    }
    if (!first.empty() && ++later == kFramesApart) {
      samples.push_back(seen_in_both(first, *seen));
      first.clear();
    } else if (first.empty() &&
               seen->front().frame >= run.camera[samples.size() * run.camera.size() / kSamples].frame) {
      first.assign(seen->begin(), seen->end());
      later = 0;
    }
  }
  return samples;
}

struct Counts {
  std::size_t points = 0;
  std::size_t found = 0;
};

/// None of a sample whose images the recording does not have.
Counts find_points(const Sample& sample, RecordedImages& images) {
  const Result<GrayView> first = images.left(sample.first_frame);
  if (!first) {
    return {};
  }
  std::vector<std::optional<AffineTemplate>> patches;
  for (const Eigen::Vector2d& at_px : sample.first_px) {
    patches.push_back(AffineTemplate::make(*first, at_px, kPatchSigma_px));
  }
  const Result<GrayView> later = images.left(sample.later_frame);
  if (!later) {
    return {};
  }
  Counts counts{patches.size(), 0};
  for (std::size_t i = 0; i < patches.size(); ++i) {
    counts.found += patches[i] && patches[i]->align(*later, {sample.later_px[i]}, kGate) ? 1 : 0;
  }
  return counts;
}

recording::CommonTimes find_times(const recording::Run& run, const hal::FrameList& frames) {
  std::vector<std::int64_t> times_ns;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    times_ns.push_back(frames[i].timestamp_ns);
  }
  return recording::common_times(run, std::move(times_ns));
}

std::string numbers(std::size_t found, std::size_t of, const char* what) {
  return std::to_string(found) + " of " + std::to_string(of) + what;
}

/// What shows that it is another recording; empty if nothing does.
std::string difference(const recording::Run& run, RecordedImages& images) {
  const StereoGeometry& geometry = images.geometry();
  if (run.rectified.width_px != 0 &&
      (geometry.width_px != run.rectified.width_px || geometry.height_px != run.rectified.height_px)) {
    return "its images are not of the same size";
  }
  Counts points;
  for (const Sample& sample : samples_of(run)) {
    const Counts of_sample = find_points(sample, images);
    points.points += of_sample.points;
    points.found += of_sample.found;
  }
  if (points.points >= kMinPoints) {
    const bool is_same = static_cast<double>(points.found) >= kMinShare * static_cast<double>(points.points);
    return is_same ? "" : numbers(points.found, points.points, " points of the run are in its images");
  }
  const recording::CommonTimes times = find_times(run, images.frames());
  return times.are_most() ? "" : numbers(times.common, times.frames, " times of its frames are the run's");
}

}  // namespace

Status check_same_recording(const recording::Run& run, const std::string& name, RecordedImages& images) {
  const std::string different = run.camera.empty() ? "" : difference(run, images);
  if (different.empty()) {
    return {};
  }
  return fail(ErrorCode::kBadFormat, name + ": is another recording than that of " + run.directory.string() +
                                         (run.dataset.empty() ? "" : " (" + run.dataset + ")") + ": " + different +
                                         "; give the recording that the run was made from");
}

}  // namespace kinetrace::figure
