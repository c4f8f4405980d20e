#include "colmap_writer.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>

#include "buffered_file.hpp"
#include "external_sort.hpp"
#include "spool_reader.hpp"

namespace kinetrace::recording {
namespace {

constexpr double kPixelOrigin = 0.5;  // COLMAP puts the centre of the first pixel at (0.5, 0.5), Kinetrace at (0, 0).
constexpr int kPixelDecimals = 3;
constexpr int kDigits = 9;

using Observations = SpoolFile<ObservationRecord>;

std::uint32_t image_id(std::int32_t frame) {
  return static_cast<std::uint32_t>(frame) + 1;  // COLMAP's ids start at 1.
}

std::filesystem::path model_directory(const Workspace& workspace, std::uint32_t track_id) {
  return workspace.config.directory / "colmap" /
         (track_id == kBackgroundTrack ? "background" : "object_" + std::to_string(track_id));
}

/// Names of the model's images.
std::string_view images_note(const RecordingConfig& config) {
  return config.images ? "Images: those in images/ of the run folder."
         : of_recorded_images(config)
             ? "Images: the recorded ones, which are rectified."
             : "Images: rectified ones, not those recorded; `kinetrace run --images` writes them.";
}

Status write_cameras(const Workspace& workspace, const std::filesystem::path& directory) {
  Result<BufferedWriter> out = BufferedWriter::create(directory / "cameras.txt", workspace.slice(4));
  if (!out) {
    return Unexpected(out.error());
  }
  const StereoGeometry& geometry = workspace.config.geometry;
  out->text("# CAMERA_ID MODEL WIDTH HEIGHT fx fy cx cy: the rectified left camera\n# ")
      .text(images_note(workspace.config));
  out->text("\n1 PINHOLE ");
  out->integer(geometry.width_px).text(" ").integer(geometry.height_px);
  for (const double value :
       {geometry.fx_px, geometry.fy_px, geometry.cx_px + kPixelOrigin, geometry.cy_px + kPixelOrigin}) {
    out->text(" ").general(value, 12);
  }
  out->text("\n");
  return out->close();
}

/// Writes points3D.txt body by body; creates each folder with its cameras.txt.
class ModelWriter {
 public:
  explicit ModelWriter(const Workspace& workspace) : workspace_(workspace) {}

  Status begin(std::uint32_t track_id) {
    if (Status closed = points_.close(); !closed) {
      return closed;
    }
    const std::filesystem::path directory = model_directory(workspace_, track_id);
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) {
      return file_error("create", directory, error.value());
    }
    if (Status cameras = write_cameras(workspace_, directory); !cameras) {
      return cameras;
    }
    Result<BufferedWriter> points = BufferedWriter::create(directory / "points3D.txt", workspace_.slice(4));
    if (!points) {
      return Unexpected(points.error());
    }
    points_ = std::move(*points);
    points_.text("# POINT3D_ID X Y Z R G B ERROR (IMAGE_ID POINT2D_IDX)...: body frame, metres; error in pixels\n");
    track_id_ = track_id;
    return {};
  }
  [[nodiscard]] std::uint32_t track_id() const { return track_id_; }
  [[nodiscard]] BufferedWriter& points() { return points_; }

 private:
  const Workspace& workspace_;
  std::uint32_t track_id_ = kBackgroundTrack;
  BufferedWriter points_;
};

void write_point(const PointRecord& point, BufferedWriter& out) {
  out.integer(point.point_id);
  for (const float coordinate : point.position_m) {
    out.text(" ").general(static_cast<double>(coordinate), kDigits);
  }
  for (int channel = 0; channel < 3; ++channel) {
    out.text(" ").integer(point.intensity);
  }
  out.text(" ").general(static_cast<double>(point.error_px), kDigits);
}

/// The final point of an observation, or nullptr. Call in ascending order.
const PointRecord* find_point(SpoolFile<PointRecord>& points, const ObservationRecord& key) {
  const auto of_observation = std::tie(key.track_id, key.point_id);
  const PointRecord* point = points.peek();
  while (point != nullptr && std::tie(point->track_id, point->point_id) < of_observation) {
    points.advance();
    point = points.peek();
  }
  return point != nullptr && std::tie(point->track_id, point->point_id) == of_observation ? point : nullptr;
}

bool same_point(const ObservationRecord& a, const ObservationRecord* b) {
  return b != nullptr && a.track_id == b->track_id && a.point_id == b->point_id;
}

/// Copies `observation` and the following ones of the same point to `marked`, with `point_id`; lists them in `points3d`
/// if given.
void write_observations(ObservationRecord observation, std::uint32_t point_id, Observations& observations,
                        BufferedWriter* points3d, BufferedWriter& marked) {
  const ObservationRecord key = observation;
  for (;;) {
    if (points3d != nullptr) {
      points3d->text(" ").integer(image_id(observation.frame)).text(" ").integer(observation.index);
    }
    observation.point_id = point_id;
    marked.record(observation);
    const ObservationRecord* next = observations.peek();
    if (!same_point(key, next)) {
      return;
    }
    observation = *next;
    observations.advance();
  }
}

/// Joins observations (sorted by point) with the final points: writes points3D.txt of each body and, to
/// `marked_path`, all observations again, with kNoPoint where the point is not exported.
Status write_points(const Workspace& workspace, const std::filesystem::path& marked_path, RunCounts& counts) {
  Observations observations(workspace.observations(), workspace.slice(0));
  SpoolFile<PointRecord> points(workspace.points(), workspace.slice(1));
  ModelWriter model(workspace);
  for (const Status& opened : {observations.open(), points.open(), model.begin(kBackgroundTrack)}) {
    if (!opened) {
      return opened;
    }
  }
  Result<BufferedWriter> marked = BufferedWriter::create(marked_path, workspace.slice(2));
  if (!marked) {
    return Unexpected(marked.error());
  }
  while (const ObservationRecord* next = observations.peek()) {
    const ObservationRecord first = *next;
    const PointRecord* point = find_point(points, first);
    observations.advance();
    if (point == nullptr || !same_point(first, observations.peek())) {
      write_observations(first, kNoPoint, observations, nullptr, *marked);
      continue;
    }
    if (first.track_id != model.track_id()) {
      if (Status begun = model.begin(first.track_id); !begun) {
        return begun;
      }
      ++counts.object_models;
    }
    write_point(*point, model.points());
    write_observations(first, first.point_id, observations, &model.points(), *marked);
    model.points().text("\n");
  }
  for (const Status& status : {observations.status(), points.status(), model.points().close()}) {
    if (!status) {
      return status;
    }
  }
  return marked->close();
}

/// `stem.png` as recorded for the frame.
Status write_image_name(SpoolFile<NameRecord>& names, std::int32_t frame, BufferedWriter& out) {
  std::uint64_t first = 0;
  std::uint64_t last = names.size();
  while (first < last) {
    const std::uint64_t middle = first + (last - first) / 2;
    names.seek(middle);
    const NameRecord* record = names.peek();
    if (record == nullptr) {
      return names.status();
    }
    if (record->frame == frame) {
      out.text(record->stem.data()).text(".png\n");
      return {};
    }
    (record->frame < frame ? first : last) = record->frame < frame ? middle + 1 : middle;
  }
  return fail(ErrorCode::kInternal, "no name was recorded for frame " + std::to_string(frame));
}

/// Writes the observations of one image as a line. Skips those of earlier images (of bodies without a model).
Status write_image_points(const PoseRecord& pose, Observations& observations, BufferedWriter& out) {
  const auto image = std::tie(pose.track_id, pose.frame);
  const ObservationRecord* observation = observations.peek();
  while (observation != nullptr && std::tie(observation->track_id, observation->frame) < image) {
    observations.advance();
    observation = observations.peek();
  }
  std::string_view separator;
  while (observation != nullptr && std::tie(observation->track_id, observation->frame) == image) {
    out.text(separator).fixed(static_cast<double>(observation->u_px) + kPixelOrigin, kPixelDecimals);
    out.text(" ").fixed(static_cast<double>(observation->v_px) + kPixelOrigin, kPixelDecimals);
    out.text(" ").integer(observation->point_id == kNoPoint ? std::int64_t{-1} : std::int64_t{observation->point_id});
    separator = " ";
    observations.advance();
    observation = observations.peek();
  }
  out.text("\n");
  return observations.status();
}

Status write_image(const PoseRecord& pose, SpoolFile<NameRecord>& names, Observations& observations,
                   BufferedWriter& out) {
  const StoredPose T_cam_body = StoredPose::from(pose.T_body_cam.pose().inverse());
  const auto& [x, y, z, w] = T_cam_body.quaternion_xyzw;
  out.integer(image_id(pose.frame));
  for (const double value : {w, x, y, z}) {
    out.text(" ").fixed(value, 12);
  }
  for (const double value : T_cam_body.translation_m) {
    out.text(" ").fixed(value, 9);
  }
  out.text(" 1 ");
  if (Status named = write_image_name(names, pose.frame, out); !named) {
    return named;
  }
  return write_image_points(pose, observations, out);
}

/// Opens images.txt of a body that has a model; a switched-off writer for the others.
Result<BufferedWriter> create_images(const Workspace& workspace, std::uint32_t track_id) {
  const std::filesystem::path directory = model_directory(workspace, track_id);
  if (!std::filesystem::exists(directory / "points3D.txt")) {
    return BufferedWriter{};
  }
  Result<BufferedWriter> out = BufferedWriter::create(directory / "images.txt", workspace.slice(4));
  if (out) {
    out->text(
        "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME: body to camera, metres; IMAGE_ID is the frame number + 1\n"
        "# X Y POINT3D_ID...\n");
  }
  return out;
}

/// images.txt of each body that has points3D.txt, from poses (sorted by body) and marked observations (by image).
Status write_images(const Workspace& workspace, const std::filesystem::path& marked_path) {
  SpoolFile<PoseRecord> poses(workspace.poses(), workspace.slice(0));
  Observations observations(marked_path, workspace.slice(1));
  // Buffer of one record: names are looked up by bisection.
  SpoolFile<NameRecord> names(workspace.names(), workspace.slice(2).first(sizeof(NameRecord)));
  for (const Status& opened : {poses.open(), observations.open(), names.open()}) {
    if (!opened) {
      return opened;
    }
  }
  std::uint32_t track_id = kBackgroundTrack;
  Result<BufferedWriter> out = create_images(workspace, track_id);
  for (; out && poses.peek() != nullptr; poses.advance()) {
    const PoseRecord pose = *poses.peek();
    if (pose.track_id != track_id) {
      track_id = pose.track_id;
      if (Status closed = out->close(); !closed) {
        return closed;
      }
      out = create_images(workspace, track_id);
    }
    if (out && out->is_open() && pose.body_tracked != 0) {
      if (Status image = write_image(pose, names, observations, *out); !image) {
        return image;
      }
    }
  }
  if (!out) {
    return Unexpected(out.error());
  }
  const Status closed = out->close();
  return poses.status() ? closed : poses.status();
}

}  // namespace

Status keep_image_observations(const Workspace& workspace) {
  const std::filesystem::path path = workspace.observations();
  const std::filesystem::path kept_path = path.string() + ".kept";
  Observations observations(path, workspace.slice(0));
  SpoolFile<PoseRecord> poses(workspace.poses(), workspace.slice(1));
  if (Status opened = observations.open(); !opened) {
    return opened;
  }
  if (Status opened = poses.open(); !opened) {
    return opened;
  }
  Result<BufferedWriter> kept = BufferedWriter::create(kept_path, workspace.slice(2));
  if (!kept) {
    return Unexpected(kept.error());
  }
  std::array<std::uint32_t, kMaxObjects + 1>
      tracked{};  // Bodies tracked by their own reconstruction in the current frame.
  std::size_t tracked_count = 0;
  std::int32_t frame = -1;
  for (; const ObservationRecord* observation = observations.peek(); observations.advance()) {
    if (observation->frame != frame) {
      frame = observation->frame;
      tracked_count = 0;
      for (const PoseRecord* pose = poses.peek(); pose != nullptr && pose->frame <= frame; pose = poses.peek()) {
        if (pose->frame == frame && pose->body_tracked != 0) {
          tracked[tracked_count++] = pose->track_id;
        }
        poses.advance();
      }
    }
    const auto end = tracked.begin() + static_cast<std::ptrdiff_t>(tracked_count);
    if (std::find(tracked.begin(), end, observation->track_id) != end) {
      kept->record(*observation);
    }
  }
  for (const Status& status : {observations.status(), poses.status(), kept->close()}) {
    if (!status) {
      return status;
    }
  }
  std::error_code error;
  std::filesystem::rename(kept_path, path, error);
  return error ? Status(file_error("replace", path, error.value())) : Status{};
}

Status write_colmap_models(const Workspace& workspace, RunCounts& counts) {
  const std::filesystem::path marked_path = workspace.spool("marked.bin");
  if (Status sorted = sort_file<ObservationRecord>(workspace.observations(), workspace.memory, by_point); !sorted) {
    return sorted;
  }
  if (Status points = write_points(workspace, marked_path, counts); !points) {
    return points;
  }
  if (Status sorted = sort_file<ObservationRecord>(marked_path, workspace.memory, by_image); !sorted) {
    return sorted;
  }
  return write_images(workspace, marked_path);
}

}  // namespace kinetrace::recording
