#include <set>
#include <string>
#include <utility>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "truth_files.hpp"

namespace kinetrace::evaluation {
namespace {

constexpr std::uint16_t kOtherClass = 3;

std::uint16_t class_of(std::string_view name) {
  return name == "car" ? kVehicleClass : name == "pedestrian" ? kPedestrianClass : kOtherClass;
}

}  // namespace

Result<ObjectsByFrame> read_simulator_objects(const std::filesystem::path& path) {
  Result<TextRows> rows = TextRows::open(path, TextRows::Separator::kComma);
  if (!rows) {
    return Unexpected(rows.error());
  }
  const std::vector<std::size_t> column =
      rows->columns({"frame", "object_id", "class", "moving", "rigid", "tx", "vx", "vy", "vz", "height", "visible_px",
                     "height_px", "length", "width", "occlusion", "truncation"});
  ObjectsByFrame objects;
  std::set<std::pair<std::int64_t, std::int64_t>> known;  // Frame and object.
  while (rows->next()) {
    const std::int64_t frame = rows->integer(column[0]);
    const std::int64_t id = rows->integer(column[1]);
    if (!known.emplace(frame, id).second) {
      rows->reject("frame " + std::to_string(frame) + " has object " + std::to_string(id) + " twice");
    }
    if (!std::in_range<std::uint32_t>(id)) {
      rows->reject("object_id " + std::to_string(id) + " is out of range");
    }
    LocatedObject located;
    TrueObject& object = located.object;
    object.id = static_cast<std::uint32_t>(id);
    object.class_id = class_of(rows->text(column[2]));
    object.moving = rows->integer(column[3]) != 0;
    object.rigid = rows->integer(column[4]) != 0;
    object.T_world_obj = rows->pose(column[5]);
    object.velocity_mps = {rows->number(column[6]), rows->number(column[7]), rows->number(column[8])};
    // The origin is on the ground below the box's middle, y points down.
    located.center_m = object.T_world_obj * Eigen::Vector3d(0.0, -rows->number(column[9]) / 2.0, 0.0);
    object.height_px = static_cast<int>(rows->integer(column[11]));
    object.size_m = {rows->number(column[12]), rows->number(column[9]), rows->number(column[13])};
    object.hidden = std::max(rows->number(column[14]), rows->number(column[15]));
    if (rows->integer(column[10]) > 0) {
      objects[frame].push_back(located);
    }
  }
  if (!rows->ends_with_whole_row()) {
    rows->reject("the last row is cut off; copy the truth again");
  }
  if (!rows->status()) {
    return Unexpected(rows->status().error());
  }
  return objects;
}

}  // namespace kinetrace::evaluation
