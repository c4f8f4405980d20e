#include "kinetrace/recording/run_recorder.hpp"

#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "buffered_file.hpp"
#include "colmap_writer.hpp"
#include "external_sort.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "mots_rows.hpp"
#include "observation_file.hpp"
#include "point_cloud_writer.hpp"
#include "run_folder.hpp"
#include "run_json.hpp"
#include "spool.hpp"
#include "track_writer.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {
namespace {

/// PLY, COLMAP and the spool hold frame numbers in 31 bits; COLMAP adds one.
constexpr std::int64_t kMaxFrame = std::numeric_limits<std::int32_t>::max() - 1;

std::size_t memory_bytes(const RecordingConfig& config) {
  constexpr std::size_t kBytesPerKib = 1024;
  return static_cast<std::size_t>(config.conversion_kib) * kBytesPerKib;
}

Unexpected<Error> bad_frame(std::int64_t frame, const std::string& reason) {
  return fail(ErrorCode::kInvalidArgument, "cannot record frame " + std::to_string(frame) + ": " + reason);
}

}  // namespace

Status RecordingConfig::validate() const {
  if (directory.empty()) {
    return fail(ErrorCode::kInvalidConfig, "recording.directory must name a folder, got an empty name");
  }
  if (!(geometry.fx_px > 0.0 && geometry.fy_px > 0.0 && geometry.width_px > 0 && geometry.height_px > 0)) {
    return fail(ErrorCode::kInvalidConfig, "recording.geometry must have a focal length and an image size above zero");
  }
  constexpr std::int64_t kMaxVertices = 1'000'000'000;
  for (const Status& status :
       {check_range("recording.max_objects", max_objects, 1, kMaxObjects),
        check_range("recording.flush_interval_frames", flush_interval_frames, 1, 100'000),
        check_range("recording.conversion_kib", conversion_kib, 64, 262'144),
        check_range<std::int64_t>("recording.max_trajectory_vertices", max_trajectory_vertices, 1, kMaxVertices)}) {
    if (!status) {
      return status;
    }
  }
  return {};
}

struct RunRecorder::Impl {
  RecordingConfig config;
  FolderLock lock;
  std::span<std::byte> memory;  ///< Write buffers during the run, working memory of the conversion afterwards.
  BufferedWriter camera_tum, camera_kitti, camera_frames, objects, labels, mots, kept_observations;
  BufferedWriter poses, observations, points, names;
  MotsRows mots_rows;
  std::int64_t newest_frame = -1;
  std::int64_t finalised_frame = -1;
  int frames_since_flush = 0;
  RunCounts counts;
  bool finished = false;
  Status first_error;

  Status open_files();
  Status check(const FrameResult& result) const;
  Status check_finalised(const FrameResult& result) const;
  Status append(const FrameResult& result);
  void append_newest(const FrameResult& result) noexcept;
  [[nodiscard]] NameRecord image_name(const RectifiedPair& pair) const noexcept;
  Status write_image(const RectifiedPair& pair);
  void append_retired(const FrameResult& result) noexcept;
  void append_finalised(const FrameEstimate& frame) noexcept;
  void append_object(const FrameEstimate& frame, const ObjectResult& object) noexcept;
  [[nodiscard]] Status check_folder_is_there() const;
  Status flush_when_due();
  Status close_files();
  Status convert();
  Status write_about(const RunSummary& summary, const std::filesystem::path& name,
                     std::span<const FileEntry> files) const;

  [[nodiscard]] std::array<BufferedWriter*, 11> writers() noexcept {
    return {&camera_tum,        &camera_kitti, &camera_frames, &objects, &labels, &mots,
            &kept_observations, &poses,        &observations,  &points,  &names};
  }
};

Status RunRecorder::Impl::open_files() {
  struct File {
    BufferedWriter* writer;
    const char* name;
    bool wanted;
  };
  const std::array<File, 11> files{{{&camera_tum, "camera.tum", true},
                                    {&camera_kitti, "camera_kitti.txt", true},
                                    {&camera_frames, kCameraFramesFile.data(), true},
                                    {&objects, "objects.csv", true},
                                    {&labels, "label_02.txt", true},
                                    {&mots, "mots.txt", config.mots},
                                    {&kept_observations, kObservationFile.data(), config.observations},
                                    {&poses, ".spool/poses.bin", true},
                                    {&observations, ".spool/observations.bin", config.colmap},
                                    {&points, ".spool/points.bin", config.points || config.colmap},
                                    {&names, ".spool/names.bin", config.colmap}}};
  const std::size_t buffer_bytes = memory.size() / (files.size() + 1);
  mots_rows = MotsRows(memory.subspan(files.size() * buffer_bytes, buffer_bytes));
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!files[i].wanted) {
      continue;
    }
    Result<BufferedWriter> writer =
        BufferedWriter::create(config.directory / files[i].name, memory.subspan(i * buffer_bytes, buffer_bytes));
    if (!writer) {
      return Unexpected(writer.error());
    }
    *files[i].writer = std::move(*writer);
  }
  camera_frames.text(kCameraFramesHeader);
  objects.text(kObjectsHeader);
  kept_observations.text(kObservationHeader);
  // Readers of a run in progress find the headers, and a full disk is detected now.
  const Status flushed = camera_frames.flush();
  return flushed ? objects.flush() : flushed;
}

Status RunRecorder::Impl::check(const FrameResult& result) const {
  const std::int64_t frame = result.newest.frame_index;
  if (frame < 0 || frame > kMaxFrame) {
    return bad_frame(frame, "frame numbers must be in [0, " + std::to_string(kMaxFrame) + "]");
  }
  if (frame < newest_frame) {
    return bad_frame(frame, "frame " + std::to_string(newest_frame) + " came before; record in ascending order");
  }
  return result.has_finalised ? check_finalised(result) : Status{};
}

Status RunRecorder::Impl::check_finalised(const FrameResult& result) const {
  const FrameEstimate& finalised = result.finalised;
  if (finalised.frame_index <= finalised_frame || finalised.frame_index > result.newest.frame_index) {
    return bad_frame(finalised.frame_index,
                     "it finalises out of order, after frame " + std::to_string(finalised_frame));
  }
  if (finalised.objects.size() > static_cast<std::size_t>(config.max_objects)) {
    return fail(ErrorCode::kCapacity, "cannot record frame " + std::to_string(finalised.frame_index) + ": " +
                                          std::to_string(finalised.objects.size()) +
                                          " objects exceed recording.max_objects " +
                                          std::to_string(config.max_objects) + "; raise it");
  }
  if (!finalised.camera.T_world_cam.is_finite()) {
    return bad_frame(finalised.frame_index, "the camera's pose is not finite");
  }
  for (const ObjectResult& object : finalised.objects) {
    const bool finite = object.T_world_obj.is_finite() && object.T_obj_cam.is_finite();
    if (object.status != BodyStatus::kInitializing && !finite) {
      return bad_frame(finalised.frame_index,
                       "the pose of object " + std::to_string(object.track_id) + " is not finite");
    }
  }
  return {};
}

Status RunRecorder::Impl::append(const FrameResult& result) {
  if (Status checked = check(result); !checked) {
    return checked;
  }
  const bool is_new = result.newest.frame_index > newest_frame;  // drain() repeats the last frame.
  newest_frame = result.newest.frame_index;
  if (is_new) {
    append_newest(result);
    if (config.images) {
      if (Status written = write_image(result.pair); !written) {
        return written;
      }
    }
  }
  append_retired(result);
  if (result.has_finalised) {
    finalised_frame = result.finalised.frame_index;
    append_finalised(result.finalised);
  }
  return flush_when_due();
}

void RunRecorder::Impl::append_newest(const FrameResult& result) noexcept {
  if (config.mots) {
    counts.mask_rows += static_cast<std::uint64_t>(mots_rows.append(result, mots));
  }
  names.record(image_name(result.pair));
  for (const BodyGeometry& body : result.bodies) {
    ObservationRecord record{.track_id = body.track_id, .frame = static_cast<std::int32_t>(newest_frame)};
    counts.observations += config.observations ? body.observations.size() : 0;
    for (const PointObservation& observation : body.observations) {
      record.point_id = observation.point_id;
      record.u_px = observation.u_left_px;
      record.v_px = observation.v_px;
      observations.record(record);
      ++record.index;
      kept_observations.record(Observation{.track_id = body.track_id,
                                           .point_id = observation.point_id,
                                           .frame = record.frame,
                                           .u_left_px = observation.u_left_px,
                                           .v_px = observation.v_px,
                                           .u_right_px = observation.u_right_px});
    }
  }
}

NameRecord RunRecorder::Impl::image_name(const RectifiedPair& pair) const noexcept {
  NameRecord record{.frame = static_cast<std::int32_t>(newest_frame)};
  const std::string_view suffix = of_recorded_images(config) ? "" : kRectifiedSuffix;
  // The frame number replaces a name that is not unique, too long, or invalid in a line or path.
  const bool is_usable = !config.repeats && !pair.name.empty() &&
                         pair.name.size() + suffix.size() < record.stem.size() &&
                         pair.name.find_first_of(" \t\r\n/") == std::string_view::npos;
  if (is_usable) {
    std::memcpy(record.stem.data(), pair.name.data(), pair.name.size());
    std::memcpy(record.stem.data() + pair.name.size(), suffix.data(), suffix.size());
  } else {
    std::snprintf(record.stem.data(), record.stem.size(), "%010d%s", record.frame, suffix.data());
  }
  return record;
}

Status RunRecorder::Impl::write_image(const RectifiedPair& pair) {
  const NameRecord name = image_name(pair);
  const std::filesystem::path path = config.directory / "images" / (std::string(name.stem.data()) + ".png");
  ++counts.images;
  return imaging::write_png_gray8(path.c_str(), pair.left, imaging::PngEffort::kFast);
}

void RunRecorder::Impl::append_retired(const FrameResult& result) noexcept {
  for (const BodyGeometry& body : result.bodies) {
    for (const BodyPoint& point : body.retired) {
      const Eigen::Vector3f& position = point.position_m;
      points.record(PointRecord{.track_id = body.track_id,
                                .point_id = point.id,
                                .frame = static_cast<std::int32_t>(newest_frame),
                                .position_m = {position.x(), position.y(), position.z()},
                                .error_px = point.reprojection_error_px,
                                .observations = point.observations,
                                .intensity = point.intensity});
    }
  }
}

void RunRecorder::Impl::append_finalised(const FrameEstimate& frame) noexcept {
  const Se3& T_world_cam = frame.camera.T_world_cam;
  write_tum_row(frame.timestamp_ns, StoredPose::from(T_world_cam), camera_tum);
  write_kitti_row(T_world_cam, camera_kitti);
  write_frame_row(frame, camera_frames);
  const std::uint32_t tracked = frame.camera.status == BodyStatus::kTracked ? 1 : 0;
  poses.record(PoseRecord{.track_id = kBackgroundTrack,
                          .frame = static_cast<std::int32_t>(frame.frame_index),
                          .timestamp_ns = frame.timestamp_ns,
                          .body_tracked = tracked,
                          .world_tracked = tracked,
                          .T_body_cam = StoredPose::from(T_world_cam),
                          .T_world_body = StoredPose::from(Se3{})});
  for (const ObjectResult& object : frame.objects) {
    append_object(frame, object);
  }
}

void RunRecorder::Impl::append_object(const FrameEstimate& frame, const ObjectResult& object) noexcept {
  if (object.status == BodyStatus::kInitializing) {
    return;
  }
  write_object_row(frame, object, objects);
  ++counts.object_rows;
  if (object.status == BodyStatus::kLost) {
    return;
  }
  counts.label_rows += write_label_row(frame, object, labels) ? 1 : 0;
  const bool tracked = object.status == BodyStatus::kTracked;
  const Eigen::Vector3f box_center_m = (object.T_world_obj.inverse() * object.box.center_m).cast<float>();
  poses.record(PoseRecord{.track_id = object.track_id,
                          .frame = static_cast<std::int32_t>(frame.frame_index),
                          .timestamp_ns = frame.timestamp_ns,
                          .body_tracked = tracked ? 1U : 0U,
                          .world_tracked = tracked && frame.camera.status == BodyStatus::kTracked ? 1U : 0U,
                          .T_body_cam = StoredPose::from(object.T_obj_cam),
                          .T_world_body = StoredPose::from(object.T_world_obj),
                          .box_center_m = {box_center_m.x(), box_center_m.y(), box_center_m.z()},
                          .box_radius_m = static_cast<float>(object.box.size_m.norm() / 2.0)});
}

// Open files can be written after somebody has removed them, for nothing.
Status RunRecorder::Impl::check_folder_is_there() const {
  std::error_code error;
  if (std::filesystem::is_directory(config.directory, error)) {
    return {};
  }
  return fail(ErrorCode::kIo, config.directory.string() +
                                  ": has gone while the run was writing into it; its results are lost, run again");
}

Status RunRecorder::Impl::flush_when_due() {
  const bool due = ++frames_since_flush >= config.flush_interval_frames;
  if (due) {
    frames_since_flush = 0;
    for (BufferedWriter* writer :
         {&camera_tum, &camera_kitti, &camera_frames, &objects, &labels, &mots, &kept_observations}) {
      if (Status flushed = writer->flush(); !flushed) {
        return flushed;
      }
    }
    if (Status there = check_folder_is_there(); !there) {
      return there;
    }
  }
  for (const BufferedWriter* writer : writers()) {
    if (writer->failed()) {
      return writer->status();
    }
  }
  return {};
}

Status RunRecorder::Impl::close_files() {
  counts.mask_rows += static_cast<std::uint64_t>(mots_rows.finish(mots));
  Status first;
  for (BufferedWriter* writer : writers()) {
    Status closed = writer->close();
    if (first && !closed) {
      first = std::move(closed);
    }
  }
  return first;
}

Status RunRecorder::Impl::convert() {
  const Workspace workspace{config, memory};
  if (config.colmap) {
    if (Status kept = keep_image_observations(workspace); !kept) {
      return kept;
    }
  }
  if (Status sorted = sort_file<PoseRecord>(workspace.poses(), memory, by_body_and_frame); !sorted) {
    return sorted;
  }
  if (Status tracks = write_tracks(workspace, counts); !tracks) {
    return tracks;
  }
  if (config.points || config.colmap) {
    if (Status kept = keep_final_points(workspace, counts); !kept) {
      return kept;
    }
  }
  if (config.points) {
    if (Status clouds = write_point_clouds(workspace, counts); !clouds) {
      return clouds;
    }
  }
  if (config.colmap) {
    if (Status models = write_colmap_models(workspace, counts); !models) {
      return models;
    }
  }
  return {};
}

Status RunRecorder::Impl::write_about(const RunSummary& summary, const std::filesystem::path& name,
                                      std::span<const FileEntry> files) const {
  const Result<std::string> text = run_json_text(summary, config.geometry, files, counts.stray_points);
  return text ? replace_file(config.directory / name, *text) : Unexpected(text.error());
}

RunRecorder::RunRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunRecorder::RunRecorder(RunRecorder&&) noexcept = default;
RunRecorder& RunRecorder::operator=(RunRecorder&&) noexcept = default;
RunRecorder::~RunRecorder() = default;

std::size_t RunRecorder::required_bytes(const RecordingConfig& config) {
  return measure_bytes([&](Arena& arena) { static_cast<void>(arena.take<std::byte>(memory_bytes(config))); });
}

Status RunRecorder::check_folder(const std::filesystem::path& directory) {
  return check_run_folder(directory);
}

Result<RunRecorder> RunRecorder::create(const RecordingConfig& config, Arena& arena) {
  if (Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  impl->memory = arena.take<std::byte>(memory_bytes(config));
  if (impl->memory.empty()) {
    return fail(ErrorCode::kCapacity, "recording needs " + std::to_string(memory_bytes(config)) +
                                          " bytes of working memory, which the arena does not have; raise the memory "
                                          "budget or lower recording.conversion_kib");
  }
  Result<FolderLock> lock = prepare_run_folder(config);
  if (!lock) {
    return Unexpected(lock.error());
  }
  impl->lock = std::move(*lock);
  if (Status opened = impl->open_files(); !opened) {
    return Unexpected(opened.error());
  }
  return RunRecorder(std::move(impl));
}

Status RunRecorder::begin(const RunSummary& summary) {
  return impl_->write_about(summary, kBegunPath, {});
}

Status RunRecorder::record(const FrameResult& result) {
  if (!impl_->first_error) {
    return impl_->first_error;
  }
  if (impl_->finished) {
    return fail(ErrorCode::kIllegalState, "cannot record: the run folder is finished");
  }
  Status appended = impl_->append(result);
  if (!appended) {
    impl_->first_error = appended;
  }
  return appended;
}

Status RunRecorder::finish(const RunSummary& summary) {
  if (impl_->finished) {
    return fail(ErrorCode::kIllegalState, "cannot finish: the run folder is finished already");
  }
  impl_->finished = true;
  const Status closed = first_failure({impl_->close_files(), impl_->check_folder_is_there()});
  if (!impl_->first_error || !closed) {
    return impl_->first_error ? closed : impl_->first_error;
  }
  if (Status converted = impl_->convert(); !converted) {
    return converted;
  }
  const std::vector<FileEntry> files = list_files(impl_->config, impl_->counts);
  if (Status written = impl_->write_about(summary, "run.json", files); !written) {
    return written;
  }
  const std::filesystem::path spool = impl_->config.directory / ".spool";
  std::error_code error;
  std::filesystem::remove_all(spool, error);
  return error ? Status(file_error("remove", spool, error.value())) : Status{};
}

}  // namespace kinetrace::recording
