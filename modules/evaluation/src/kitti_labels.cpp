#include <algorithm>
#include <set>
#include <utility>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "truth_files.hpp"

namespace kinetrace::evaluation {
namespace {

constexpr std::uint16_t kOtherClass = 3;
constexpr std::size_t kFields = 17;
constexpr std::size_t kFieldsWithScore = 18;
constexpr double kMoving_mps = 1.0;  // Labels are noisy: parked cars appear to move by some decimetres.

struct KittiType {
  std::string_view name;
  std::uint16_t class_id;
  bool rigid;
};
constexpr std::array<KittiType, 9> kTypes{{{"Car", kVehicleClass, true},
                                           {"Van", kVehicleClass, true},
                                           {"Truck", kVehicleClass, true},
                                           {"Tram", kVehicleClass, true},
                                           {"Pedestrian", kPedestrianClass, false},
                                           {"Person", kPedestrianClass, false},
                                           {"Person_sitting", kPedestrianClass, false},
                                           {"Cyclist", kOtherClass, false},
                                           {"Misc", kOtherClass, true}}};

/// A label in its camera's frame: box upright there, location below its middle, rotation 0 = length along +x.
LocatedObject read_label(TextRows& rows, const KittiType& type, const Se3& T_world_cam) {
  LocatedObject located;
  const std::int64_t id = rows.integer(1);
  if (!std::in_range<std::uint32_t>(id)) {
    rows.reject("track id " + std::to_string(id) + " is out of range");
  }
  located.object.id = static_cast<std::uint32_t>(id);
  located.object.class_id = type.class_id;
  located.object.rigid = type.rigid;
  located.box_px = {rows.number(6), rows.number(7), rows.number(8), rows.number(9)};
  located.object.height_px = static_cast<int>(std::lround(located.box_px.y1 - located.box_px.y0));
  const Eigen::Vector3d location_m(rows.number(13), rows.number(14), rows.number(15));
  const Se3 T_cam_obj{so3_exp({0.0, rows.number(16), 0.0}), location_m};
  located.object.T_world_obj = T_world_cam * T_cam_obj;
  located.object.size_m = {rows.number(12), rows.number(10), rows.number(11)};
  located.center_m = located.object.T_world_obj * Eigen::Vector3d(0.0, -rows.number(10) / 2.0, 0.0);
  return located;
}

struct TimedObject {
  std::int64_t timestamp_ns = 0;
  TrueObject* object = nullptr;
};

// Central differences over up to five rows, one-sided at both ends.
void set_velocities(std::vector<TimedObject>& track) {
  constexpr std::size_t kReach = 2;
  for (std::size_t i = 0; i < track.size(); ++i) {
    const TimedObject& before = track[i - std::min(i, kReach)];
    const TimedObject& after = track[std::min(i + kReach, track.size() - 1)];
    const double elapsed_s = 1e-9 * static_cast<double>(after.timestamp_ns - before.timestamp_ns);
    if (elapsed_s > 0.0) {
      track[i].object->velocity_mps =
          (after.object->T_world_obj.translation - before.object->T_world_obj.translation) / elapsed_s;
    }
    track[i].object->moving = track[i].object->velocity_mps.norm() > kMoving_mps;
  }
}

}  // namespace

Result<ObjectsByFrame> read_kitti_labels(const std::filesystem::path& path, const TrueCamera& camera,
                                         const TruthSource& source) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kBlanks);
  if (!rows) {
    return Unexpected(rows.error());
  }
  ObjectsByFrame objects;
  std::set<std::pair<std::int64_t, std::int64_t>> labelled;  // Frame and track.
  bool is_empty = true;
  while (rows->next()) {
    is_empty = false;
    if (rows->size() != kFields && rows->size() != kFieldsWithScore) {
      rows->reject("expected 17 fields, or 18 with a score, found " + std::to_string(rows->size()));
      break;
    }
    const std::int64_t frame = rows->integer(0);
    const std::string_view name = rows->text(2);
    if (name != "DontCare" && !labelled.emplace(frame, rows->integer(1)).second) {
      rows->reject("frame " + std::to_string(frame) + " has track " + std::to_string(rows->integer(1)) + " twice");
    }
    const auto type = std::find_if(kTypes.begin(), kTypes.end(), [&](const KittiType& t) { return t.name == name; });
    const auto time = source.frame_times_ns.find(frame);
    if (name == "DontCare" || time == source.frame_times_ns.end()) {
      continue;
    }
    if (type == kTypes.end()) {
      rows->reject(std::string("KITTI has no type ").append(name));
      break;
    }
    if (const std::optional<Se3> T_world_cam = camera.at(frame, time->second, source.time_tolerance_ns)) {
      objects[frame].push_back(read_label(*rows, *type, *T_world_cam));
    }
  }
  if (is_empty) {
    rows->reject("the file holds no label");
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  std::map<std::uint32_t, std::vector<TimedObject>> tracks;
  for (auto& [frame, located] : objects) {
    for (LocatedObject& one : located) {
      tracks[one.object.id].push_back({source.frame_times_ns.at(frame), &one.object});
    }
  }
  for (auto& [id, track] : tracks) {
    set_velocities(track);
  }
  return objects;
}

}  // namespace kinetrace::evaluation
