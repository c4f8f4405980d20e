// Objects of a run, cut into pieces for each formulation to solve.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "kinetrace/evaluation/truth.hpp"
#include "object_history.hpp"

namespace kinetrace::batch {

// Limits of a piece of an object's life: points in each frame, and frames.
inline constexpr std::size_t kMinPoints = 8;
inline constexpr std::size_t kMinFrames = 5;
inline constexpr std::size_t kMaxFrames = 50;
inline constexpr double kMinDisparity_px = 0.25;
inline constexpr double kSigma_px = 0.07;  // As estimated by the refinement of objects.

/// A point of an object; SeenPoint::frame counts from the first frame of the piece.
struct PointTrack {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< Object frame.
  std::vector<SeenPoint> seen;
};

/// An object in consecutive frames, from row `first` of Run::camera on.
struct Piece {
  StereoGeometry geometry;
  double sigma_px = kSigma_px;
  std::size_t first = 0;
  std::vector<Se3> T_world_cam;  ///< True.
  std::vector<Se3> T_world_obj;  ///< The run's poses relative to the camera.
  std::vector<Eigen::Vector3d> box_centres_m;
  std::vector<double> times_s;
  std::vector<PointTrack> points;
};

/// Points of a piece with observations in two frames, each at the mean of its stereo positions.
inline std::vector<PointTrack> points_of(const Piece& piece, const ObjectHistory& history) {
  struct Mean {
    PointTrack point;
    double weight = 0.0;
  };
  std::map<std::uint32_t, Mean> means;
  for (std::size_t k = 0; k < piece.T_world_obj.size(); ++k) {
    for (SeenPoint seen : history.seen.at(piece.first + k)) {
      seen.frame = static_cast<std::uint32_t>(k);
      Mean& mean = means[seen.point_id];
      mean.point.seen.push_back(seen);
      const Eigen::Vector3d px = seen.px.cast<double>();
      if (const double disparity_px = px.x() - px.z(); disparity_px > kMinDisparity_px) {
        const Eigen::Vector3d p_cam = piece.geometry.triangulate(px.x(), px.y(), disparity_px);
        const double weight = std::pow(p_cam.z(), -4.0);
        mean.weight += weight;
        mean.point.position_m +=
            (piece.T_world_obj[k].inverse() * (piece.T_world_cam[k] * p_cam) - mean.point.position_m) *
            (weight / mean.weight);
      }
    }
  }
  std::vector<PointTrack> points;
  for (auto& [id, mean] : means) {
    if (mean.weight > 0.0 && mean.point.seen.size() > 1) {
      points.push_back(std::move(mean.point));
    }
  }
  return points;
}

/// Adds the run's pose, relative to the true camera.
inline void append_frame(const recording::CameraRow& camera, const recording::ObjectRow& object, const Se3& T_world_cam,
                         Piece& piece) {
  const Se3 T_true_run = T_world_cam * camera.T_world_cam.inverse();
  piece.T_world_cam.push_back(T_world_cam);
  piece.T_world_obj.push_back((T_true_run * object.T_world_obj).orthonormalised());
  piece.box_centres_m.push_back(T_true_run * object.box.center_m);
  piece.times_s.push_back(1e-9 * static_cast<double>(camera.timestamp_ns));
}

/// Adds the pieces of an object: consecutive tracked frames with enough points.
inline void cut_into_pieces(const recording::Run& run, const evaluation::TrueCamera& truth,
                            const ObjectHistory& history, std::vector<Piece>& pieces) {
  Piece piece;
  const auto finish = [&] {
    if (piece.T_world_obj.size() >= kMinFrames) {
      piece.geometry = run.rectified;
      piece.points = points_of(piece, history);
      pieces.push_back(std::move(piece));
    }
    piece = {};
  };
  for (const auto& [row, object] : history.rows) {
    const recording::CameraRow& camera = run.camera[row];
    const auto T_world_cam = truth.at(camera.frame, camera.timestamp_ns, 0);
    const auto seen = history.seen.find(row);
    const std::size_t points = seen == history.seen.end() ? 0 : seen->second.size();
    const bool fits = object.status == BodyStatus::kTracked && points >= kMinPoints && T_world_cam.has_value();
    if (!fits || row != piece.first + piece.T_world_obj.size() || piece.T_world_obj.size() == kMaxFrames) {
      finish();
      piece.first = row;
    }
    if (fits) {
      append_frame(camera, object, *T_world_cam, piece);
    }
  }
  finish();
}

/// Makes a separate point for each pair of consecutive frames that see one. All but the first and last observations
/// then count twice, hence the noise.
inline Piece by_frame_pairs(Piece piece) {
  std::vector<PointTrack> pairs;
  for (const PointTrack& point : piece.points) {
    for (std::size_t i = 1; i < point.seen.size(); ++i) {
      pairs.push_back({point.position_m, {point.seen[i - 1], point.seen[i]}});
    }
  }
  piece.points = std::move(pairs);
  piece.sigma_px *= std::sqrt(2.0);
  return piece;
}

}  // namespace kinetrace::batch
