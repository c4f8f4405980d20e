#include "kinetrace/recording/run_reader.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "folder_lock.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "mots_rows.hpp"
#include "run_about.hpp"
#include "run_folder.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTumFields = 8;
constexpr std::size_t kPoseFields = 12;
constexpr std::size_t kMaskFields = 6;
constexpr std::size_t kLabelFields = 18;
constexpr double kUnitTolerance = 0.01;
constexpr std::int64_t kUnnumbered = -1;

/// Opens a file of rows; of an unfinished file only whole rows count.
Result<TextRows> open_rows(const fs::path& path, TextRows::Separator separator, bool is_finished) {
  Result<TextRows> rows = TextRows::open(path, separator);
  if (rows && !is_finished) {
    rows->leave_out_unfinished_row();
  }
  return rows;
}

/// Checks, after the last row, that it is whole and that the number of rows is that of run.json.
Status check_end(TextRows& rows, std::size_t found, std::optional<std::int64_t> expected) {
  if (!rows.ends_with_whole_row()) {
    rows.reject("the last row is cut off; copy the run folder again");
  }
  if (expected && std::cmp_not_equal(found, *expected)) {
    rows.reject("the file ends after " + std::to_string(found) + " rows, run.json tells of " +
                std::to_string(*expected) + "; copy the run folder again");
  }
  return rows.status();
}

std::optional<std::int64_t> reported_rows(const RunAbout& about, const char* file) {
  const auto found = about.rows.find(file);
  return found == about.rows.end() ? std::nullopt : std::optional(found->second);
}

/// Tolerance for rounding: one file has a micrometre and a billionth, the other nine digits.
bool is_same_pose(const Se3& a, const Se3& b) {
  constexpr double kTolerance = 1e-6;
  constexpr double kDigits = 1e-8;
  const double apart_m = (a.translation - b.translation).cwiseAbs().maxCoeff();
  return apart_m <= kTolerance + kDigits * b.translation.norm() &&
         (a.rotation - b.rotation).cwiseAbs().maxCoeff() <= kTolerance;
}

// camera.tum has the times; camera_kitti.txt has the same poses with all digits.
Status read_camera(const RunAbout& about, Run& run) {
  Result<TextRows> times = open_rows(run.directory / "camera.tum", TextRows::Separator::kBlanks, run.is_finished);
  if (!times) {
    return Unexpected(times.error());
  }
  Result<TextRows> poses = open_rows(run.directory / "camera_kitti.txt", TextRows::Separator::kBlanks, run.is_finished);
  if (!poses) {
    return Unexpected(poses.error());
  }
  times->expect_fields(kTumFields);
  poses->expect_fields(kPoseFields);
  while (times->next()) {
    if (!poses->next()) {
      if (run.is_finished) {
        poses->reject("the file has fewer rows than camera.tum");
      }
      break;
    }
    CameraRow row;
    row.frame = kUnnumbered;
    row.timestamp_ns = times->time_ns(0);
    if (!run.camera.empty() && row.timestamp_ns <= run.camera.back().timestamp_ns) {
      times->reject("the time does not grow from the row before");
    }
    row.T_world_cam = poses->matrix_pose(0);
    if (poses->status() && !is_same_pose(times->pose(1), row.T_world_cam)) {
      poses->reject("the pose is not that of the same row of camera.tum");
    }
    run.camera.push_back(row);
  }
  if (!run.is_finished) {
    return times->status() ? poses->status() : times->status();
  }
  if (poses->next()) {
    poses->reject("the file has more rows than camera.tum");
  }
  for (const TextRows* rows : {&*times, &*poses}) {
    if (!rows->status()) {
      return rows->status();
    }
  }
  const Status whole = check_end(*times, run.camera.size(), about.frames);
  return whole ? check_end(*poses, run.camera.size(), about.frames) : whole;
}

/// Runs of earlier versions have no such file: their frames are numbered by number_frames.
Status read_frame_numbers(const RunAbout& about, Run& run) {
  const fs::path path = run.directory / kCameraFramesFile;
  if (std::error_code error; !fs::exists(path, error)) {
    return {};
  }
  Result<TextRows> rows = open_rows(path, TextRows::Separator::kComma, run.is_finished);
  if (!rows) {
    return Unexpected(rows.error());
  }
  const std::vector<std::size_t> places = rows->columns({"frame", "timestamp_ns"});
  std::size_t count = 0;
  for (; rows->next(); ++count) {
    if (count == run.camera.size()) {
      if (run.is_finished) {
        rows->reject("the file has more rows than camera.tum");
      }
      break;
    }
    CameraRow& row = run.camera[count];
    row.frame = rows->integer(places[0]);
    if (rows->integer(places[1]) != row.timestamp_ns) {
      rows->reject("the time is not that of the same row of camera.tum");
    }
    const std::int64_t before = count > 0 ? run.camera[count - 1].frame : kUnnumbered;
    if (!std::in_range<std::int32_t>(row.frame) || row.frame <= before) {
      rows->reject("the frame number does not grow from the row before");
    }
  }
  if (run.is_finished) {
    return check_end(*rows, count, about.frames);
  }
  run.camera.resize(count);
  return rows->status();
}

std::uint16_t parse_class(std::string_view name, TextRows& rows) {
  constexpr std::string_view kNumbered = "class_";
  if (name == "unknown") {
    return kUnknownClass;
  }
  if (name == "car") {
    return kVehicleClass;
  }
  if (name == "pedestrian") {
    return kPedestrianClass;
  }
  const std::optional<std::int64_t> number =
      name.starts_with(kNumbered) ? parse_integer(name.substr(kNumbered.size())) : std::nullopt;
  if (!number || *number < 0 || *number > 0xffff) {
    rows.reject("'" + std::string(name) + "' is no class");
    return kUnknownClass;
  }
  return static_cast<std::uint16_t>(*number);
}

BodyStatus parse_status(std::string_view name, TextRows& rows) {
  for (const BodyStatus status :
       {BodyStatus::kTracked, BodyStatus::kStereoOnly, BodyStatus::kPropagated, BodyStatus::kLost}) {
    if (name == to_string(status)) {
      return status;
    }
  }
  rows.reject("'" + std::string(name) + "' is no status");
  return BodyStatus::kLost;
}

std::vector<std::string_view> object_columns() {
  std::vector<std::string_view> names;
  const std::string_view header = kObjectsHeader.substr(0, kObjectsHeader.size() - 1);
  for (std::size_t begin = 0; begin < header.size();) {
    const std::size_t end = std::min(header.find(',', begin), header.size());
    names.push_back(header.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

/// Reads the columns of a row in the order of the writer's header.
class ColumnReader {
 public:
  ColumnReader(TextRows& rows, const std::vector<std::size_t>& places) : rows_(rows), places_(places) {}

  /// Whether the file has the next column.
  [[nodiscard]] bool has_next() const { return places_[next_] != TextRows::kNoColumn; }
  std::string_view text() { return rows_.text(places_[next_++]); }
  double number() { return rows_.number(places_[next_++]); }
  Eigen::Vector3d vector() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }
  template <typename Integer>
  Integer integer() {
    const std::int64_t value = rows_.integer(places_[next_++]);
    if (!std::in_range<Integer>(value)) {
      rows_.reject(std::to_string(value) + " is out of range");
    }
    return static_cast<Integer>(value);
  }
  Se3 pose() {
    const std::size_t first = places_[next_];
    next_ += 7;
    return rows_.pose(first);
  }

 private:
  TextRows& rows_;
  const std::vector<std::size_t>& places_;
  std::size_t next_ = 0;
};

ObjectRow object_row(TextRows& rows, const std::vector<std::size_t>& places) {
  ColumnReader columns(rows, places);
  ObjectRow row;
  row.frame = columns.integer<std::int32_t>();
  row.timestamp_ns = columns.integer<std::int64_t>();
  row.track_id = columns.integer<std::uint32_t>();
  row.class_id = parse_class(columns.text(), rows);
  row.status = parse_status(columns.text(), rows);
  row.T_world_obj = columns.pose();
  row.velocity_mps = columns.vector();
  row.moving = columns.integer<int>() != 0;
  row.heading_rad = columns.number();
  row.box.center_m = columns.vector();
  row.box.size_m = columns.vector();
  row.box.yaw_rad = columns.number();
  row.variances.head<3>() = columns.vector();
  row.variances.tail<3>() = columns.vector();
  row.point_count = columns.integer<int>();
  row.inliers = columns.integer<int>();
  row.pixel_height = columns.integer<int>();
  for (int* edge : {&row.mask_px.x0, &row.mask_px.y0, &row.mask_px.x1, &row.mask_px.y1}) {
    *edge = columns.integer<int>();
  }
  if (columns.has_next()) {
    row.box.down = columns.vector();
    row.box_sigma.center_m = columns.vector();
    row.box_sigma.size_m = columns.vector();
    row.box_sigma.yaw_rad = columns.number();
    row.box_sigma.heading_known = columns.integer<int>() != 0;
    if (std::abs(row.box.down.norm() - 1.0) > kUnitTolerance) {
      rows.reject("box_down is not of unit length");
    }
  }
  return row;
}

/// Checks the consistency of the rows of objects.csv with each other and with the camera's.
class ObjectRowCheck {
 public:
  explicit ObjectRowCheck(const std::vector<CameraRow>& camera) {
    for (const CameraRow& row : camera) {
      frame_at_time_.emplace(row.timestamp_ns, row.frame);
    }
  }

  /// Whether the camera's files have the row's frame. Errors are reported to `rows`.
  bool check(const ObjectRow& row, bool is_finished, TextRows& rows) {
    if (row.frame < frame_) {
      rows.reject("the frame number falls from the row before");
    }
    if (row.frame != frame_) {
      tracks_.clear();
    } else if (row.timestamp_ns != timestamp_ns_) {
      rows.reject("the time is not that of the same frame's row before");
    }
    frame_ = row.frame;
    timestamp_ns_ = row.timestamp_ns;
    if (!tracks_.insert(row.track_id).second) {
      rows.reject("frame " + std::to_string(row.frame) + " has track " + std::to_string(row.track_id) + " twice");
    }
    const auto camera = frame_at_time_.find(row.timestamp_ns);
    const bool has_camera = camera != frame_at_time_.end();
    const bool is_ahead = frame_at_time_.empty() || row.timestamp_ns > frame_at_time_.rbegin()->first;
    if (!has_camera && (is_finished || !is_ahead)) {
      rows.reject("camera.tum has no frame at this time");
    }
    if (has_camera && camera->second != kUnnumbered && camera->second != row.frame) {
      rows.reject("the frame at this time has number " + std::to_string(camera->second) + " in " +
                  std::string(kCameraFramesFile));
    }
    return has_camera;
  }

 private:
  std::map<std::int64_t, std::int64_t> frame_at_time_;  ///< Of the camera's rows.
  std::set<std::uint32_t> tracks_;                      ///< Tracks of the current frame.
  std::int64_t frame_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t timestamp_ns_ = 0;
};

Status read_objects(const RunAbout& about, Run& run) {
  Result<TextRows> rows = open_rows(run.directory / "objects.csv", TextRows::Separator::kComma, run.is_finished);
  if (!rows) {
    return Unexpected(rows.error());
  }
  const std::vector<std::size_t> places = rows->columns(object_columns(), kColumnsOfAllVersions);
  ObjectRowCheck check(run.camera);
  while (rows->next()) {
    const ObjectRow row = object_row(*rows, places);
    if (rows->status() && check.check(row, run.is_finished, *rows)) {
      run.objects.push_back(row);
    }
  }
  return run.is_finished ? check_end(*rows, run.objects.size(), reported_rows(about, "objects.csv")) : rows->status();
}

/// Labels are not read back, but an incomplete file marks a damaged folder.
Status check_labels(const RunAbout& about, Run& run) {
  const std::optional<std::int64_t> reported = reported_rows(about, "label_02.txt");
  if (!reported || !run.is_finished) {
    return {};
  }
  Result<TextRows> rows = TextRows::open(run.directory / "label_02.txt", TextRows::Separator::kBlanks);
  if (!rows) {
    return Unexpected(rows.error());
  }
  rows->expect_fields(kLabelFields);
  std::size_t found = 0;
  while (rows->next()) {
    ++found;
  }
  return check_end(*rows, found, reported);
}

std::int64_t typical_interval_ns(const std::vector<CameraRow>& camera) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < camera.size(); ++i) {
    intervals.push_back(camera[i].timestamp_ns - camera[i - 1].timestamp_ns);
  }
  return intervals.empty() ? 1 : median(intervals);
}

// For runs of earlier versions. A source may skip frames. Frames with objects are numbered in objects.csv; the number
// of a frame without objects follows from its neighbour's by the elapsed time in frame intervals.
void number_frames(Run& run) {
  std::map<std::int64_t, std::int64_t> frame_at_time;
  for (const ObjectRow& object : run.objects) {
    frame_at_time.emplace(object.timestamp_ns, object.frame);
  }
  const std::int64_t interval_ns = typical_interval_ns(run.camera);
  const auto step = [&](std::size_t row) {  // From row - 1 to row.
    const std::int64_t elapsed_ns = run.camera[row].timestamp_ns - run.camera[row - 1].timestamp_ns;
    const bool rounds_up = elapsed_ns % interval_ns >= interval_ns - interval_ns / 2;
    constexpr std::int64_t kFar = std::numeric_limits<std::int32_t>::max();  // Frame numbers have 32 bits.
    return std::clamp<std::int64_t>(elapsed_ns / interval_ns + (rounds_up ? 1 : 0), 1, kFar);
  };
  std::size_t first_known = run.camera.size();
  run.camera.front().frame = 0;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    const auto known = frame_at_time.find(run.camera[row].timestamp_ns);
    if (known != frame_at_time.end()) {
      run.camera[row].frame = known->second;
      first_known = std::min(first_known, row);
    } else if (row > 0) {
      run.camera[row].frame = run.camera[row - 1].frame + step(row);
    }
  }
  for (std::size_t row = std::min(first_known, run.camera.size()); row-- > 0;) {
    if (first_known < run.camera.size()) {
      run.camera[row].frame = run.camera[row + 1].frame - step(row + 1);
    }
  }
}

constexpr std::int64_t kMaxSide = 8192;  ///< Bound for images of unknown size.

std::string size_text(std::int64_t width_px, std::int64_t height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px);
}

MaskRow mask_row(const StereoGeometry& rectified, TextRows& rows) {
  MaskRow row;
  row.frame = rows.integer(0);
  const std::int64_t object_id = rows.integer(1);
  const std::int64_t class_id = rows.integer(2);
  const bool are_ids = std::in_range<std::uint16_t>(class_id) && object_id >= 0;
  const std::int64_t track_id = are_ids ? mots_track_id(class_id, object_id) : -1;
  const std::int64_t height_px = rows.integer(3);
  const std::int64_t width_px = rows.integer(4);
  row.rle = rows.text(5);
  if (!std::in_range<std::uint32_t>(track_id)) {
    rows.reject("obj_id " + std::to_string(object_id) + " does not fit class_id " + std::to_string(class_id));
  }
  const bool is_size_known = rectified.width_px > 0;
  const bool fits = is_size_known ? width_px == rectified.width_px && height_px == rectified.height_px
                                  : width_px > 0 && width_px <= kMaxSide && height_px > 0 && height_px <= kMaxSide;
  if (!fits) {
    std::string reason = "a mask of an image of ";
    reason.append(size_text(width_px, height_px)).append(" pixels");
    if (is_size_known) {
      reason.append(", the run's have ").append(size_text(rectified.width_px, rectified.height_px));
    }
    rows.reject(reason);
  }
  row.track_id = static_cast<std::uint32_t>(track_id);
  row.class_id = static_cast<std::uint16_t>(class_id);
  row.width_px = static_cast<int>(width_px);
  row.height_px = static_cast<int>(height_px);
  return row;
}

/// Reads run.json, or the description of an unfinished run.
Result<RunAbout> read_about(Run& run, bool is_in_use) {
  std::error_code error;
  if (fs::exists(run.directory / "run.json", error)) {
    return read_run_about(run.directory / "run.json");
  }
  if (!fs::exists(run.directory / "camera.tum", error)) {
    if (fs::exists(run.directory, error) && !fs::is_directory(run.directory, error)) {
      return unreachable(run.directory, "expected the folder of a run (kinetrace run --out)");
    }
    return unreachable(run.directory / "run.json", "no such file; expected the folder of a run (kinetrace run --out)");
  }
  run.is_finished = false;
  run.notes.push_back(run.directory.string() +
                      (is_in_use ? ": a run is still writing into it; taking what there is so far"
                                 : ": the run did not end in good order (there is no run.json); taking what there is"));
  const fs::path begun = run.directory / kBegunPath;
  return fs::exists(begun, error) ? read_run_about(begun) : RunAbout{};
}

}  // namespace

Result<Run> read_run(const fs::path& directory) {
  Run run;
  run.directory = directory;
  run.lock = std::make_shared<const FolderLock>(FolderLock::take(directory, FolderUse::kRead));
  Result<RunAbout> about = read_about(run, run.lock->is_refused());
  if (!about) {
    return Unexpected(about.error());
  }
  for (Status (*read)(const RunAbout&, Run&) : {&read_camera, &read_frame_numbers, &read_objects, &check_labels}) {
    if (const Status done = read(*about, run); !done) {
      return Unexpected(done.error());
    }
  }
  run.mask_rows = reported_rows(*about, "mots.txt");
  run.observation_rows = reported_rows(*about, "observations.bin");
  run.dataset = std::move(about->dataset);
  run.dataset_fields = std::move(about->dataset_fields);
  run.sequence = std::move(about->sequence);
  run.cameras = std::move(about->cameras);
  run.passes = static_cast<std::int64_t>(std::clamp(parse_number(about->passes).value_or(1.0), 1.0, 1e6));
  run.config_json = std::move(about->config_json);
  run.warnings = std::move(about->warnings);
  run.rectified = about->rectified;
  run.applied = about->applied;
  if (!run.camera.empty() && run.camera.front().frame == kUnnumbered) {
    number_frames(run);
  }
  return run;
}

Result<std::vector<MaskRow>> read_masks(const Run& run) {
  std::vector<MaskRow> masks;
  const fs::path path = run.directory / "mots.txt";
  if (std::error_code error; !run.mask_rows && !fs::exists(path, error)) {
    return masks;
  }
  Result<TextRows> rows = open_rows(path, TextRows::Separator::kBlanks, run.is_finished);
  if (!rows) {
    return Unexpected(rows.error());
  }
  rows->expect_fields(kMaskFields);
  while (rows->next()) {
    masks.push_back(mask_row(run.rectified, *rows));
  }
  const Status whole = run.is_finished ? check_end(*rows, masks.size(), run.mask_rows) : rows->status();
  if (!whole) {
    return Unexpected(whole.error());
  }
  std::stable_sort(masks.begin(), masks.end(), [](const MaskRow& a, const MaskRow& b) { return a.frame < b.frame; });
  return masks;
}

}  // namespace kinetrace::recording
