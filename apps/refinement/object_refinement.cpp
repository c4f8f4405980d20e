#include "object_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinetrace/core/body_velocity.hpp"
#include "object_rows.hpp"

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;

// As object.turn_rate_radps: a prior against the noisy rotation of short tracks with few points.
constexpr double kUsualTurn_radps = 0.1;
// Lower bound of the frame-to-frame sigma of stereo-only positions.
constexpr double kPositionFloor_m = 0.02;
constexpr double kRotationFloor_rad = 0.02;
// Stereo-only positions come from a filter: errors of this many frames are correlated and count as one.
constexpr double kCorrelatedFrames = 8.0;
// Fewer points do not determine a pose.
constexpr std::size_t kMinPoints = 8;

Vector6d of_turn_and_way(double turn, double way) {
  Vector6d both;
  both << Eigen::Vector3d::Constant(turn), Eigen::Vector3d::Constant(way);
  return both;
}

/// Rows [first, last] of Run::camera in which an object was tracked without a gap.
struct Piece {
  std::size_t first = 0;
  std::size_t last = 0;
  [[nodiscard]] std::size_t size() const { return last - first + 1; }
};

std::vector<Piece> pieces_of(const ObjectHistory& history) {
  std::vector<Piece> pieces;
  for (const auto& [row, object] : history.rows) {
    if (object.status == BodyStatus::kLost) {
      continue;
    }
    if (pieces.empty() || pieces.back().last + 1 != row) {
      pieces.push_back({row, row});
    }
    pieces.back().last = row;
  }
  return pieces;
}

/// Normal of the ground in the world. Boxes have the world's y axis where the ground is not known.
std::optional<Eigen::Vector3d> vertical_of(const ObjectHistory& history) {
  const auto known = std::find_if(history.rows.rbegin(), history.rows.rend(),
                                  [](const auto& row) { return row.second.box.down != Eigen::Vector3d::UnitY(); });
  return known == history.rows.rend() ? std::nullopt : std::optional(known->second.box.down);
}

class PieceRefinement {
 public:
  PieceRefinement(const recording::Run& run, std::span<const Se3> T_world_cam, const ObjectHistory& history,
                  const Piece& piece)
      : run_(run), T_world_cam_(T_world_cam.subspan(piece.first, piece.size())), history_(history), piece_(piece) {}

  /// Stores frames and points of the piece in `object`.
  Status refine(const AdjustmentOptions& options, RefinedObject& object) {
    state_problem();
    BodyFit fit;
    const bool is_bound = !problem_.fixed_frames.empty() || !problem_.measured_poses.empty();
    if (is_bound && piece_.size() > 2 && options.keep_going()) {
      AdjustmentOptions with_covariances = options;
      with_covariances.with_covariances = true;
      Result<BodyFit> adjusted = adjust_body(problem_, with_covariances);
      if (!adjusted) {
        return Unexpected(adjusted.error());
      }
      fit = std::move(*adjusted);
    }
    for (std::size_t k = 0; k < piece_.size(); ++k) {
      RefinedObjectFrame& frame = object.frames[piece_.first + k];
      frame.row = row(k);
      frame.T_obj_cam = problem_.T_body_cam[k];
      frame.row.T_world_obj = T_world_cam_[k] * frame.T_obj_cam.inverse();
      frame.row.T_world_obj.rotation = orthonormalised(frame.row.T_world_obj.rotation);
      if (k < fit.covariances.size()) {
        frame.row.variances = world_variances(fit.covariances[k], k);
      }
    }
    for (RefinedPoint& point : fit.points) {
      point.last_frame += static_cast<std::uint32_t>(piece_.first);
      object.points.push_back(point);
    }
    return {};
  }

 private:
  [[nodiscard]] const ObjectRow& row(std::size_t k) const { return history_.rows.at(piece_.first + k); }

  /// Variances of rotation and position about the world's axes, from the covariance of the perturbation of T_cam_obj.
  /// The object's frame is that of the fixed frame; the camera's path is taken as exact.
  [[nodiscard]] Vector6d world_variances(const Matrix6d& covariance, std::size_t k) const {
    const Eigen::Matrix3d& R = T_world_cam_[k].rotation;
    Matrix6d by_perturbation;
    by_perturbation << R, Eigen::Matrix3d::Zero(), -R * skew(problem_.T_body_cam[k].inverse().translation), R;
    return (by_perturbation * covariance * by_perturbation.transpose()).diagonal();
  }

  /// Frames at rest: those without motion in the run. Before the first motion of a moving object, the run had only not
  /// detected it yet.
  void list_rest() {
    const auto moves = [&](std::size_t k) { return row(k).moving; };
    std::size_t first_moving = 0;
    while (first_moving < piece_.size() && !moves(first_moving)) {
      ++first_moving;
    }
    for (std::size_t k = 0; k < piece_.size(); ++k) {
      const bool is_known = first_moving == piece_.size() || k > first_moving;
      at_rest_.push_back(k > 0 && is_known && !moves(k) && !moves(k - 1) ? 1 : 0);
    }
  }

  void state_problem() {
    problem_.geometry = run_.rectified;
    list_rest();
    std::size_t max_points = 0;
    for (std::size_t k = 0; k < piece_.size(); ++k) {
      const recording::CameraRow& camera = run_.camera[piece_.first + k];
      problem_.T_body_cam.push_back(row(k).T_world_obj.inverse() * camera.T_world_cam);
      timestamps_ns_.push_back(camera.timestamp_ns);
      const auto seen = history_.seen.find(piece_.first + k);
      const std::size_t points = seen == history_.seen.end() ? 0 : seen->second.size();
      if (points > max_points && points >= kMinPoints) {
        max_points = points;
        problem_.fixed_frames = {static_cast<std::uint32_t>(k)};
      }
      for (std::size_t i = 0; i < points; ++i) {
        problem_.seen.push_back(seen->second[i]);
        problem_.seen.back().frame = static_cast<std::uint32_t>(k);
      }
      if (row(k).status == BodyStatus::kStereoOnly) {
        add_measurement(k);
      }
    }
    problem_.motion =
        refinement::BatchMotion{.T_world_cam = T_world_cam_,
                                .timestamps_ns = timestamps_ns_,
                                .at_rest = at_rest_,
                                .vertical = vertical_of(history_),
                                .rest_velocity = of_turn_and_way(kRestTurnSigma_radps, kRestSpeedSigma_mps),
                                .turn_rate_radps = kUsualTurn_radps};
  }

  void add_measurement(std::size_t k) {
    const Vector6d floor = of_turn_and_way(kRotationFloor_rad, kPositionFloor_m);
    const Vector6d variances = kCorrelatedFrames * (row(k).variances + floor.cwiseAbs2());
    problem_.measured_poses.push_back({static_cast<std::uint32_t>(k),
                                       T_world_cam_[k] * problem_.T_body_cam[k].inverse(),
                                       variances.cwiseSqrt().cwiseInverse()});
  }

  const recording::Run& run_;
  std::span<const Se3> T_world_cam_;
  const ObjectHistory& history_;
  Piece piece_;
  BodyProblem problem_;
  std::vector<std::int64_t> timestamps_ns_;
  std::vector<std::uint8_t> at_rest_;
};

/// Lost rows keep the run's pose relative to the camera.
void carry_lost_rows(const recording::Run& run, std::span<const Se3> T_world_cam, const ObjectHistory& history,
                     RefinedObject& object) {
  for (const auto& [row, lost] : history.rows) {
    if (!object.frames.contains(row)) {
      const Se3 T_obj_cam = lost.T_world_obj.inverse() * run.camera[row].T_world_cam;
      RefinedObjectFrame& frame = object.frames[row];
      frame = {lost, T_obj_cam};
      frame.row.T_world_obj = T_world_cam[row] * T_obj_cam.inverse();
    }
  }
}

}  // namespace

Result<RefinedObject> refine_object(const recording::Run& run, std::span<const Se3> T_world_cam,
                                    const ObjectHistory& history, const AdjustmentOptions& options) {
  RefinedObject object;
  for (const Piece& piece : pieces_of(history)) {
    if (const Status refined = PieceRefinement(run, T_world_cam, history, piece).refine(options, object); !refined) {
      return Unexpected(refined.error());
    }
  }
  carry_lost_rows(run, T_world_cam, history, object);
  place_boxes(run, history, object);
  set_velocities(object);
  return object;
}

}  // namespace kinetrace::batch
