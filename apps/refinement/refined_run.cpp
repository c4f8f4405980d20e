#include "refined_run.hpp"

#include <set>
#include <string>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/recording/mask_frames.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "run_details.hpp"
#include "run_observations.hpp"

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;
using Intensities = std::map<std::uint32_t, std::uint8_t>;

ObjectResult result_of(const RefinedObjectFrame& frame) {
  const ObjectRow& row = frame.row;
  return {.track_id = row.track_id,
          .class_id = row.class_id,
          .status = row.status,
          .moving = row.moving,
          .T_world_obj = row.T_world_obj,
          .T_obj_cam = frame.T_obj_cam,
          .covariance = row.variances.asDiagonal(),
          .velocity_mps = row.velocity_mps,
          .heading_rad = row.heading_rad,
          .box = row.box,
          .box_sigma = row.box_sigma,
          .box_px = row.mask_px,
          .point_count = row.point_count,
          .inliers = row.inliers};
}

/// Points of one body, each output with the frame that saw it last.
class LeavingPoints {
 public:
  LeavingPoints(const std::vector<RefinedPoint>& points, const Intensities& intensities) {
    for (const RefinedPoint& point : points) {
      const auto intensity = intensities.find(point.id);
      constexpr std::uint8_t kMiddleGray = 128;
      by_row_[point.last_frame].push_back(
          {.id = point.id,
           .position_m = point.position_m.cast<float>(),
           .reprojection_error_px = static_cast<float>(point.error_px),
           .observations = point.observations,
           .intensity = intensity == intensities.end() ? kMiddleGray : intensity->second});
    }
  }
  [[nodiscard]] std::span<const BodyPoint> with(std::size_t row) const {
    const auto points = by_row_.find(row);
    return points == by_row_.end() ? std::span<const BodyPoint>() : points->second;
  }

 private:
  std::map<std::size_t, std::vector<BodyPoint>> by_row_;
};

class Writer {
 public:
  Writer(const recording::Run& run, const RefinedRun& refined, recording::RunSummary summary)
      : run_(run), refined_(refined), summary_(std::move(summary)) {
    for (const auto& [track_id, object] : refined.objects) {
      for (const auto& [row, frame] : object.frames) {
        objects_[row].push_back(&frame);
      }
    }
  }

  Status write(const std::filesystem::path& directory, const std::function<void(std::size_t)>& progress) {
    if (Status read = read_details(); !read) {
      return read;
    }
    const recording::RecordingConfig config = recording_config(directory);
    Arena arena(recording::RunRecorder::required_bytes(config));
    Result<recording::RunRecorder> recorder = recording::RunRecorder::create(config, arena);
    if (!recorder) {
      return Unexpected(recorder.error());
    }
    Result<recording::MaskFrames> masks = recording::MaskFrames::open(run_);
    if (!masks) {
      return Unexpected(masks.error());
    }
    Result<RunObservations> observations = RunObservations::open(run_, refined_.measured);
    if (!observations) {
      return Unexpected(observations.error());
    }
    if (Status begun = recorder->begin(summary_); !begun) {
      return begun;
    }
    for (std::size_t row = 0; row < run_.camera.size(); ++row) {
      if (Status read = read_observations(run_.camera[row].frame, *observations); !read) {
        return read;
      }
      if (Status written = write_row(row, *masks, *recorder); !written) {
        return written;
      }
      progress(row + 1);
    }
    complete_summary();
    return recorder->finish(summary_);
  }

 private:
  recording::RecordingConfig recording_config(const std::filesystem::path& directory) const {
    std::error_code error;
    recording::RecordingConfig config;
    config.directory = directory;
    config.geometry = run_.rectified;
    config.mots = std::filesystem::exists(run_.directory / "mots.txt", error);
    config.points = std::filesystem::exists(run_.directory / "points", error);
    config.colmap = std::filesystem::exists(run_.directory / "colmap", error);
    config.is_rectified = true;  // Image names are taken unchanged from the run.
    config.conversion_kib = 16 * 1024;
    return config;
  }

  /// Into `names_` and `leaving_`.
  Status read_details() {
    Result<std::map<std::int64_t, std::string>> names = image_names(run_);
    Result<Intensities> background = background_intensities();
    if (!names || !background) {
      return Unexpected(names ? background.error() : names.error());
    }
    names_ = std::move(*names);
    leaving_.emplace(0, LeavingPoints(refined_.camera.points, *background));
    for (const auto& [track_id, object] : refined_.objects) {
      const Result<Intensities> intensities = object_intensities(track_id);
      if (!intensities) {
        return Unexpected(intensities.error());
      }
      leaving_.emplace(track_id, LeavingPoints(object.points, *intensities));
    }
    return {};
  }

  [[nodiscard]] Result<Intensities> background_intensities() const {
    Result<Intensities> intensities = point_intensities(run_, 0);
    if (!intensities) {
      return intensities;
    }
    for (const auto& [point_id, whole] : refined_.measured.part_of) {
      if (const auto known = intensities->find(whole); known != intensities->end()) {
        intensities->emplace(point_id, known->second);
      }
    }
    return intensities;
  }

  /// With those of the tracks joined to it.
  [[nodiscard]] Result<Intensities> object_intensities(std::uint32_t track_id) const {
    Result<Intensities> intensities = point_intensities(run_, track_id);
    for (const auto& [joined, into] : refined_.joined_into) {
      if (!intensities || into != track_id) {
        continue;
      }
      Result<Intensities> more = point_intensities(run_, joined);
      if (!more) {
        return more;
      }
      intensities->merge(*more);
    }
    return intensities;
  }

  /// Of the frame, into `seen_`.
  Status read_observations(std::int64_t frame, RunObservations& reader) {
    seen_.clear();
    while (!is_over_ && next_frame_ <= frame) {
      if (next_frame_ == frame) {
        seen_ = pending_;
      }
      const Result<std::span<const recording::Observation>> next = reader.next_frame();
      if (!next) {
        return Unexpected(next.error());
      }
      is_over_ = next->empty();
      pending_.clear();
      for (const recording::Observation& each : *next) {
        next_frame_ = each.frame;
        pending_[name_of(each.track_id)].push_back({each.point_id, each.u_left_px, each.v_px, each.u_right_px});
      }
    }
    return {};
  }

  Status write_row(std::size_t row, recording::MaskFrames& masks, recording::RunRecorder& recorder) {
    const recording::CameraRow& camera = run_.camera[row];
    const Result<recording::MaskFrame> painted = masks.at(camera.frame);
    if (!painted) {
      return Unexpected(painted.error());
    }
    std::vector<Track> tracks;
    for (const recording::FrameMask& mask : painted->masks) {
      // A joined track may still have been searched for in frames of its later part: the later part's mask counts.
      const std::uint32_t track_id = name_of(mask.track_id);
      std::erase_if(tracks, [&](const Track& track) { return track.id == track_id; });
      tracks.push_back({.id = track_id,
                        .slot = static_cast<std::uint8_t>(mask.label - 1),
                        .class_id = mask.class_id,
                        .state = TrackState::kConfirmed,
                        .box_px = mask.box_px});
    }
    std::vector<ObjectResult> objects;
    for (const RefinedObjectFrame* frame : objects_[row]) {
      objects.push_back(result_of(*frame));
      add_found(frame->row);
    }
    const std::vector<BodyGeometry> bodies = bodies_at(row);
    const auto name = names_.find(camera.frame);
    FrameResult result;
    result.newest.frame_index = camera.frame;
    result.newest.timestamp_ns = camera.timestamp_ns;
    result.newest.objects = objects;
    result.newest.camera.T_world_cam = refined_.camera.T_world_cam[row];
    result.newest.camera.status = is_tracked(camera.frame) ? BodyStatus::kTracked : BodyStatus::kPropagated;
    result.has_finalised = true;
    result.finalised = result.newest;
    result.bodies = bodies;
    result.tracks = tracks;
    result.left_labels = painted->labels;
    result.pair.name = name == names_.end() ? std::string_view() : std::string_view(name->second);
    return recorder.record(result);
  }

  [[nodiscard]] std::uint32_t name_of(std::uint32_t track_id) const {
    const auto joined = refined_.joined_into.find(track_id);
    return joined == refined_.joined_into.end() ? track_id : joined->second;
  }

  /// The run's COLMAP model lists the frames in which its camera was tracked; without one, all were.
  [[nodiscard]] bool is_tracked(std::int64_t frame) const { return names_.empty() || names_.contains(frame); }

  std::vector<BodyGeometry> bodies_at(std::size_t row) {
    std::vector<BodyGeometry> bodies;
    for (const auto& [track_id, points] : leaving_) {
      const auto seen = seen_.find(track_id);
      BodyGeometry body;
      body.track_id = track_id;
      body.status = BodyStatus::kTracked;
      body.retired = points.with(row);
      if (seen != seen_.end()) {
        body.observations = seen->second;
      }
      bodies.push_back(body);
    }
    return bodies;
  }

  void add_found(const ObjectRow& row) {
    if (row.status != BodyStatus::kLost) {
      found_.insert(row.track_id);
      if (row.moving) {
        moved_.insert(row.track_id);
      }
    }
  }

  void complete_summary() {
    const std::vector<Se3>& path = refined_.camera.T_world_cam;
    summary_.frames = static_cast<std::int64_t>(path.size());
    summary_.counters.frames = path.size();
    summary_.found = {.poses = path.size(), .objects = found_.size(), .objects_moved = moved_.size()};
    for (std::size_t k = 1; k < path.size(); ++k) {
      summary_.found.camera_path_m += (path[k].translation - path[k - 1].translation).norm();
    }
  }

  const recording::Run& run_;
  const RefinedRun& refined_;
  recording::RunSummary summary_;
  std::map<std::int64_t, std::string> names_;  ///< Of images, by frame.
  std::map<std::uint32_t, LeavingPoints> leaving_;
  std::map<std::size_t, std::vector<const RefinedObjectFrame*>> objects_;  ///< By row.
  std::map<std::uint32_t, std::vector<PointObservation>> seen_, pending_;  ///< By track: of the row, of a later one.
  std::int64_t next_frame_ = -1;
  bool is_over_ = false;
  std::set<std::uint32_t> found_, moved_;
};

}  // namespace

Status write_refined_run(const recording::Run& run, const RefinedRun& refined, const std::filesystem::path& directory,
                         recording::RunSummary summary, const std::function<void(std::size_t)>& progress) {
  return Writer(run, refined, std::move(summary)).write(directory, progress);
}

}  // namespace kinetrace::batch
