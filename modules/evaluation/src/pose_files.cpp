#include <algorithm>

#include "kinetrace/core/text_rows.hpp"
#include "truth_files.hpp"

namespace kinetrace::evaluation {
namespace {

/// `fields`: number per row, since rows of one format may be valid in another; 0: as many as in the first row.
template <typename ReadPose>
Result<TrueCamera> read_rows(const std::filesystem::path& path, TextRows::Separator separator, std::size_t fields,
                             bool by_time, const ReadPose& read_pose) {
  Result<TextRows> rows = TextRows::open(path, separator);
  if (!rows) {
    return Unexpected(rows.error());
  }
  TrueCamera camera;
  camera.by_time = by_time;
  rows->expect_fields(fields);
  while (rows->next()) {
    rows->expect_fields(rows->size());
    const auto number = static_cast<std::int64_t>(camera.poses.size());
    const TrueCamera::Pose pose{by_time ? rows->time_ns(0) : number, read_pose(*rows)};
    if (!camera.poses.empty() && pose.key <= camera.poses.back().key) {
      rows->reject("the time does not grow from the row before");
    }
    camera.poses.push_back(pose);
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  if (camera.poses.empty()) {
    return fail(ErrorCode::kBadFormat, path.string() + ": holds no pose");
  }
  return camera;
}

}  // namespace

std::optional<Se3> TrueCamera::at(std::int64_t frame, std::int64_t timestamp_ns, std::int64_t tolerance_ns) const {
  const std::int64_t key = by_time ? timestamp_ns : frame;
  const auto after = std::lower_bound(poses.begin(), poses.end(), key,
                                      [](const Pose& pose, std::int64_t wanted) { return pose.key < wanted; });
  const bool has_after = after != poses.end();
  if (has_after && after->key == key) {
    return after->T_world_cam;
  }
  if (!by_time) {
    return std::nullopt;
  }
  const bool before_near = after != poses.begin() && key - std::prev(after)->key <= tolerance_ns;
  const bool after_near = has_after && after->key - key <= tolerance_ns;
  if (before_near && after_near) {
    const Pose& before = *std::prev(after);
    const double s = static_cast<double>(key - before.key) / static_cast<double>(after->key - before.key);
    return interpolate(before.T_world_cam, after->T_world_cam, s);
  }
  if (before_near) {
    return std::prev(after)->T_world_cam;
  }
  return after_near ? std::optional(after->T_world_cam) : std::nullopt;
}

Result<TrueCamera> read_kitti_poses(const std::filesystem::path& path) {
  return read_rows(path, TextRows::Separator::kBlanks, 12, false, [](TextRows& rows) { return rows.matrix_pose(0); });
}

Result<TrueCamera> read_tum(const std::filesystem::path& path) {
  return read_rows(path, TextRows::Separator::kBlanks, 8, true, [](TextRows& rows) { return rows.pose(1); });
}

Result<TrueCamera> read_euroc(const std::filesystem::path& path, const Se3& T_body_cam) {
  return read_rows(path, TextRows::Separator::kComma, 0, true, [&](TextRows& rows) {
    // Unlike in the other formats, the real part of the quaternion comes first.
    return rows.pose(1, TextRows::QuaternionOrder::kRealFirst) * T_body_cam;
  });
}

}  // namespace kinetrace::evaluation
