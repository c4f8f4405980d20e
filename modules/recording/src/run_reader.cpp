#include "kinetrace/recording/run_reader.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

Status read_about(const fs::path& path, Run& run) {
  std::ifstream file(path);
  if (!file) {
    return fail(ErrorCode::kNotFound,
                path.string() + ": no such file; expected the folder of a run that has finished (kinetrace run --out)");
  }
  try {
    const nlohmann::ordered_json about = nlohmann::ordered_json::parse(file);
    run.dataset = about.at("dataset").value("dataset", "");
    run.sequence = about.at("dataset").value("sequence", "");
    run.config_json = about.at("config").dump();
    run.frames = about.at("frames").get<std::int64_t>();
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::kBadFormat, path.string() + ": is not the run.json of a run (" + error.what() + ")");
  }
  return {};
}

// camera.tum has the times; camera_kitti.txt has the same poses with all digits.
Status read_camera(const fs::path& directory, Run& run) {
  Result<TextRows> times = TextRows::open(directory / "camera.tum", TextRows::Separator::kBlanks);
  if (!times) {
    return Unexpected(times.error());
  }
  Result<TextRows> poses = TextRows::open(directory / "camera_kitti.txt", TextRows::Separator::kBlanks);
  if (!poses) {
    return Unexpected(poses.error());
  }
  while (times->next()) {
    CameraRow row;
    row.timestamp_ns = times->time_ns(0);
    if (!run.camera.empty() && row.timestamp_ns <= run.camera.back().timestamp_ns) {
      times->reject("the time does not grow from the row before");
    }
    if (!poses->next()) {
      poses->reject("the file has fewer rows than camera.tum");
    }
    row.T_world_cam = poses->matrix_pose(0);
    run.camera.push_back(row);
  }
  if (poses->next()) {
    poses->reject("the file has more rows than camera.tum");
  }
  return times->status() ? poses->status() : times->status();
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

/// Reads the columns of a row one after the other, as the writer's header lists them.
class ColumnReader {
 public:
  ColumnReader(TextRows& rows, const std::vector<std::size_t>& places) : rows_(rows), places_(places) {}

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
      rows_.reject("'" + std::to_string(value) + "' is out of range");
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
  row.frame = columns.integer<std::int64_t>();
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
  return row;
}

Status read_objects(const fs::path& path, Run& run) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kComma);
  if (!rows) {
    return Unexpected(rows.error());
  }
  const std::vector<std::size_t> places = rows->columns(object_columns());
  while (rows->next()) {
    const ObjectRow row = object_row(*rows, places);
    if (!run.objects.empty() && row.frame < run.objects.back().frame) {
      rows->reject("the frame number falls from the row before");
    }
    run.objects.push_back(row);
  }
  return rows->status();
}

std::int64_t typical_interval_ns(const std::vector<CameraRow>& camera) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < camera.size(); ++i) {
    intervals.push_back(camera[i].timestamp_ns - camera[i - 1].timestamp_ns);
  }
  if (intervals.empty()) {
    return 1;
  }
  std::nth_element(intervals.begin(), intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2),
                   intervals.end());
  return intervals[intervals.size() / 2];
}

// A source may leave frames out. Frames with objects are numbered in objects.csv; a frame without any is as many
// numbers from its neighbour as intervals fit between the two.
void number_frames(Run& run) {
  std::map<std::int64_t, std::int64_t> frame_at_time;
  for (const ObjectRow& object : run.objects) {
    frame_at_time.emplace(object.timestamp_ns, object.frame);
  }
  const std::int64_t interval_ns = typical_interval_ns(run.camera);
  const auto step = [&](std::size_t row) {  // From row - 1 to row.
    const std::int64_t elapsed_ns = run.camera[row].timestamp_ns - run.camera[row - 1].timestamp_ns;
    return std::max<std::int64_t>(1, (elapsed_ns + interval_ns / 2) / interval_ns);
  };
  std::size_t first_known = run.camera.size();
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

MaskRow mask_row(TextRows& rows) {
  MaskRow row;
  row.frame = rows.integer(0);
  const std::int64_t object_id = rows.integer(1);
  const std::int64_t class_id = rows.integer(2);
  const std::int64_t track_id = mots_track_id(class_id, object_id);
  const std::int64_t height_px = rows.integer(3);
  const std::int64_t width_px = rows.integer(4);
  row.rle = rows.text(5);
  if (!std::in_range<std::uint16_t>(class_id) || !std::in_range<std::uint32_t>(track_id)) {
    rows.reject("obj_id " + std::to_string(object_id) + " does not fit class_id " + std::to_string(class_id));
  }
  constexpr std::int64_t kMaxSide = 1 << 16;
  if (width_px < 1 || width_px > kMaxSide || height_px < 1 || height_px > kMaxSide) {
    rows.reject("an image of " + std::to_string(width_px) + " x " + std::to_string(height_px) + " pixels");
  }
  row.track_id = static_cast<std::uint32_t>(track_id);
  row.class_id = static_cast<std::uint16_t>(class_id);
  row.width_px = static_cast<int>(width_px);
  row.height_px = static_cast<int>(height_px);
  return row;
}

}  // namespace

Result<Run> read_run(const fs::path& directory) {
  Run run;
  run.directory = directory;
  Status status = read_about(directory / "run.json", run);
  if (status) {
    status = read_camera(directory, run);
  }
  if (status) {
    status = read_objects(directory / "objects.csv", run);
  }
  if (!status) {
    return Unexpected(status.error());
  }
  number_frames(run);
  return run;
}

Result<std::vector<MaskRow>> read_masks(const fs::path& directory) {
  std::vector<MaskRow> masks;
  const fs::path path = directory / "mots.txt";
  if (std::error_code error; !fs::exists(path, error)) {
    return masks;
  }
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kBlanks);
  if (!rows) {
    return Unexpected(rows.error());
  }
  while (rows->next()) {
    masks.push_back(mask_row(*rows));
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  std::stable_sort(masks.begin(), masks.end(), [](const MaskRow& a, const MaskRow& b) { return a.frame < b.frame; });
  return masks;
}

}  // namespace kinetrace::recording
