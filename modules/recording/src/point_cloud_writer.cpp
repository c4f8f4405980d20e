#include "point_cloud_writer.hpp"

#include <bit>
#include <string>

#include "buffered_file.hpp"
#include "external_sort.hpp"
#include "spool_reader.hpp"
#include "stray_points.hpp"

namespace kinetrace::recording {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written in the machine's byte order");

constexpr std::uint16_t kMinObservations = 2;

using Points = SpoolFile<PointRecord>;
using Poses = SpoolFile<PoseRecord>;

/// Positions [first, last) of one body's records in a sorted file.
struct Range {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  [[nodiscard]] std::uint64_t size() const { return last - first; }
};

/// The records of `track_id` from the position of `file` on; leaves the position behind them.
template <typename Record>
Range take_body(SpoolFile<Record>& file, std::uint32_t track_id) {
  for (const Record* record = file.peek(); record != nullptr && record->track_id < track_id; record = file.peek()) {
    file.advance();
  }
  Range range{file.position(), file.position()};
  for (const Record* record = file.peek(); record != nullptr && record->track_id == track_id; record = file.peek()) {
    file.advance();
  }
  range.last = file.position();
  return range;
}

Result<BufferedWriter> create_ply(const Workspace& workspace, const std::string& name, const std::string& comment,
                                  std::uint64_t vertices) {
  Result<BufferedWriter> out = BufferedWriter::create(workspace.config.directory / "points" / name, workspace.slice(2));
  if (out) {
    out->text("ply\nformat binary_little_endian 1.0\ncomment ").text(comment).text("\nelement vertex ");
    out->integer(vertices).text(
        "\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property int frame\nproperty uint point_id\nend_header\n");
  }
  return out;
}

void write_vertex(const Eigen::Vector3f& position_m, const PointRecord& point, std::int32_t frame,
                  BufferedWriter& out) noexcept {
  for (int i = 0; i < 3; ++i) {
    out.record(position_m[i]);
  }
  const auto gray = static_cast<std::uint8_t>(point.intensity);
  out.record(gray).record(gray).record(gray).record(frame).record(point.point_id);
}

/// Writes the points in their body's frame.
Status write_model(const Workspace& workspace, const std::string& name, const std::string& comment, Points& points,
                   const Range& range) {
  Result<BufferedWriter> out = create_ply(workspace, name, comment, range.size());
  if (!out) {
    return Unexpected(out.error());
  }
  points.seek(range.first);
  for (; points.position() < range.last; points.advance()) {
    const PointRecord* point = points.peek();
    if (point == nullptr) {
      return points.status();
    }
    write_vertex(Eigen::Vector3f(point->position_m.data()), *point, point->frame, *out);
  }
  return out->close();
}

/// Frames in which both object and camera have a pose: only such pairs count (paper, section 2.2).
std::uint64_t count_world_frames(Poses& poses, const Range& range) {
  std::uint64_t count = 0;
  poses.seek(range.first);
  for (; poses.position() < range.last && poses.peek() != nullptr; poses.advance()) {
    count += poses.peek()->world_tracked;
  }
  return count;
}

/// The paper's trajectory (eq. 2): every point j at every frame i, p_world = T_world_obj(i) * p_obj(j).
Status write_trajectory(const Workspace& workspace, const std::string& name, Points& points, const Range& body_points,
                        Poses& poses, const Range& body_poses) {
  const std::uint64_t frames = count_world_frames(poses, body_poses);
  const auto allowed = static_cast<std::uint64_t>(workspace.config.max_trajectory_vertices);
  const std::uint64_t allowed_frames = std::max<std::uint64_t>(1, allowed / body_points.size());
  const std::uint64_t stride = std::max<std::uint64_t>(1, (frames + allowed_frames - 1) / allowed_frames);
  const std::uint64_t written_frames = (frames + stride - 1) / stride;
  const std::string comment =
      "object points at every frame, world frame, metres; frame_stride " + std::to_string(stride);
  Result<BufferedWriter> out = create_ply(workspace, name, comment, written_frames * body_points.size());
  if (!out) {
    return Unexpected(out.error());
  }
  std::uint64_t index = 0;
  poses.seek(body_poses.first);
  for (; poses.position() < body_poses.last; poses.advance()) {
    const PoseRecord* pose = poses.peek();
    if (pose == nullptr) {
      return poses.status();
    }
    if (pose->world_tracked == 0 || index++ % stride != 0) {
      continue;
    }
    const Se3 T_world_obj = pose->T_world_body.pose();
    for (points.seek(body_points.first); points.position() < body_points.last; points.advance()) {
      const PointRecord* point = points.peek();
      if (point == nullptr) {
        return points.status();
      }
      const Eigen::Vector3d p_obj = Eigen::Vector3f(point->position_m.data()).cast<double>();
      write_vertex((T_world_obj * p_obj).cast<float>(), *point, pose->frame, *out);
    }
  }
  return out->close();
}

Status write_object(const Workspace& workspace, std::uint32_t track_id, Points& points, const Range& body_points,
                    Poses& poses, const Range& body_poses) {
  const std::string stem = "object_" + std::to_string(track_id);
  const std::string comment = "object points, object frame, metres";
  if (Status model = write_model(workspace, stem + "_model.ply", comment, points, body_points); !model) {
    return model;
  }
  return write_trajectory(workspace, stem + ".ply", points, body_points, poses, body_poses);
}

}  // namespace

Status keep_final_points(const Workspace& workspace, RunCounts& counts) {
  const std::filesystem::path path = workspace.points();
  if (Status sorted = sort_file<PointRecord>(path, workspace.memory, by_body_and_point); !sorted) {
    return sorted;
  }
  const std::filesystem::path kept_path = path.string() + ".kept";
  Points points(path, workspace.slice(0));
  if (Status opened = points.open(); !opened) {
    return opened;
  }
  Poses poses(workspace.poses(), workspace.slice(2));
  if (Status opened = poses.open(); !opened) {
    return opened;
  }
  Result<BufferedWriter> kept = BufferedWriter::create(kept_path, workspace.slice(1));
  if (!kept) {
    return Unexpected(kept.error());
  }
  StrayPoints strays(poses, workspace.config.geometry);
  while (const PointRecord* record = points.peek()) {
    const PointRecord point = *record;
    points.advance();
    const PointRecord* next = points.peek();
    const bool superseded = next != nullptr && next->track_id == point.track_id && next->point_id == point.point_id;
    if (superseded || point.observations < kMinObservations) {
      continue;
    }
    if (strays.contains(point)) {
      ++counts.stray_points;
    } else {
      kept->record(point);
    }
  }
  if (!points.status() || !poses.status()) {
    return points.status() ? poses.status() : points.status();
  }
  if (Status closed = kept->close(); !closed) {
    return closed;
  }
  std::error_code error;
  std::filesystem::rename(kept_path, path, error);
  return error ? Status(file_error("replace", path, error.value())) : Status{};
}

Status write_point_clouds(const Workspace& workspace, RunCounts& counts) {
  Points points(workspace.points(), workspace.slice(0));
  Poses poses(workspace.poses(), workspace.slice(1));
  if (Status opened = points.open(); !opened) {
    return opened;
  }
  if (Status opened = poses.open(); !opened) {
    return opened;
  }
  const Range background = take_body(points, kBackgroundTrack);
  if (Status written =
          write_model(workspace, "background.ply", "background points, world frame, metres", points, background);
      !written) {
    return written;
  }
  points.seek(background.last);
  while (const PointRecord* point = points.peek()) {
    const std::uint32_t track_id = point->track_id;
    const Range body_points = take_body(points, track_id);
    const Range body_poses = take_body(poses, track_id);
    if (!points.status() || !poses.status()) {
      return points.status() ? poses.status() : points.status();
    }
    if (body_poses.size() == 0) {
      continue;  // Never reported as an object.
    }
    if (Status written = write_object(workspace, track_id, points, body_points, poses, body_poses); !written) {
      return written;
    }
    points.seek(body_points.last);
    poses.seek(body_poses.last);
    ++counts.object_clouds;
  }
  return points.status();
}

}  // namespace kinetrace::recording
