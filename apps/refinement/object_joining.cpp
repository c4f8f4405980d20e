#include "object_joining.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <vector>

#include "gap_path.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;

// After a longer occlusion, more than one object may reappear there.
constexpr double kMaxGap_s = 3.0;
// Rows needed to know the velocity at an end.
constexpr std::size_t kMinRows = 3;

/// First and last observed row of an object.
struct Life {
  std::uint32_t track_id = 0;
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t rows = 0;
};

std::optional<Life> life_of(std::uint32_t track_id, const RefinedObject& object) {
  Life life{track_id};
  for (const auto& [row, frame] : object.frames) {
    if (frame.row.status == BodyStatus::kTracked || frame.row.status == BodyStatus::kStereoOnly) {
      life.first = life.rows == 0 ? row : life.first;
      life.last = row;
      ++life.rows;
    }
  }
  return life.rows >= kMinRows ? std::optional(life) : std::nullopt;
}

bool are_alike(const ObjectRow& a, const ObjectRow& b) {
  const bool is_class_open = a.class_id == kUnknownClass || b.class_id == kUnknownClass;
  const Eigen::Vector3d variances = a.box_sigma.size_m.cwiseAbs2() + b.box_sigma.size_m.cwiseAbs2();
  const Eigen::Vector3d apart = a.box.size_m - b.box.size_m;
  const double distance = (apart.array().square() / variances.array().max(1e-4)).sum();
  return (is_class_open || a.class_id == b.class_id) && distance < kChiSquareGate3;
}

struct Candidate {
  double acceleration_mps2 = 0.0;
  std::uint32_t before = 0;
  std::uint32_t after = 0;
};

std::vector<Candidate> candidates(const std::map<std::uint32_t, RefinedObject>& objects) {
  std::vector<Life> lives;
  for (const auto& [track_id, object] : objects) {
    if (const std::optional<Life> life = life_of(track_id, object)) {
      lives.push_back(*life);
    }
  }
  std::vector<Candidate> found;
  for (const Life& before : lives) {
    for (const Life& after : lives) {
      if (before.last >= after.first) {
        continue;
      }
      const ObjectRow& from = objects.at(before.track_id).frames.at(before.last).row;
      const ObjectRow& to = objects.at(after.track_id).frames.at(after.first).row;
      const GapPath path = GapPath::between(from, to);
      if (path.is_possible(kMaxGap_s) && are_alike(from, to)) {
        found.push_back({path.acceleration_mps2(), before.track_id, after.track_id});
      }
    }
  }
  return found;
}

/// Whether no other pair with either of the two is nearly as likely.
bool is_clear(const Candidate& one, const std::vector<Candidate>& all) {
  constexpr double kClearly = 3.0;
  return std::all_of(all.begin(), all.end(), [&](const Candidate& other) {
    const bool shares = other.before == one.before || other.after == one.after;
    const bool is_same = other.before == one.before && other.after == one.after;
    return is_same || !shares || other.acceleration_mps2 > kClearly * one.acceleration_mps2;
  });
}

/// From the earlier object's frame into the later one's: the centres of the boxes coincide, and the earlier object
/// rotates with its direction of motion.
Se3 frame_change(const ObjectRow& from, const ObjectRow& to) {
  const bool is_turn_known = from.moving && to.moving;
  const double turn_rad = is_turn_known ? std::remainder(to.heading_rad - from.heading_rad, 2.0 * M_PI) : 0.0;
  const Eigen::Matrix3d R_world_a =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()).toRotationMatrix() * from.T_world_obj.rotation;
  const Eigen::Vector3d center_a_m = from.T_world_obj.inverse() * from.box.center_m;
  const Se3 T_world_a{R_world_a, to.box.center_m - R_world_a * center_a_m};
  return to.T_world_obj.inverse() * T_world_a;
}

void join(const Candidate& pair, std::map<std::uint32_t, RefinedObject>& objects) {
  RefinedObject& before = objects.at(pair.before);
  RefinedObject after = std::move(objects.at(pair.after));
  objects.erase(pair.after);
  const Life life_before = *life_of(pair.before, before);
  const Life life_after = *life_of(pair.after, after);
  const Se3 T_b_a = frame_change(before.frames.at(life_before.last).row, after.frames.at(life_after.first).row);
  before.frames.erase(before.frames.upper_bound(life_before.last), before.frames.end());
  for (auto& [row, frame] : after.frames) {
    if (row > life_before.last) {
      frame.row.track_id = pair.before;
      frame.row.T_world_obj = frame.row.T_world_obj * T_b_a;
      frame.T_obj_cam = T_b_a.inverse() * frame.T_obj_cam;
      before.frames.insert_or_assign(row, frame);
    }
  }
  for (RefinedPoint& point : after.points) {
    point.position_m = T_b_a.inverse() * point.position_m;
    before.points.push_back(point);
  }
}

}  // namespace

std::map<std::uint32_t, std::uint32_t> join_tracks(std::map<std::uint32_t, RefinedObject>& objects) {
  std::map<std::uint32_t, std::uint32_t> joined_into;
  while (true) {
    const std::vector<Candidate> all = candidates(objects);
    const auto clear = std::find_if(all.begin(), all.end(), [&](const Candidate& one) { return is_clear(one, all); });
    if (clear == all.end()) {
      return joined_into;
    }
    join(*clear, objects);
    for (auto& [track_id, now] : joined_into) {
      now = now == clear->after ? clear->before : now;
    }
    joined_into[clear->after] = clear->before;
  }
}

}  // namespace kinetrace::batch
