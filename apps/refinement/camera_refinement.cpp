#include "camera_refinement.hpp"

#include <algorithm>
#include <deque>
#include <string>
#include <unordered_map>

#include "run_observations.hpp"

namespace kinetrace::batch {
namespace {

// Points live for a few up to some tens of frames: with this overlap, both ends of the shared rows are well
// constrained.
constexpr std::size_t kSharedRows = 40;
constexpr std::size_t kMaxRows = 400;
// About 600 bytes each during the adjustment.
constexpr std::size_t kMaxObservations = 600'000;
// Error of the run's steps: relevant only in frames with very few points.
constexpr double kStepRotation_rad = 0.02;
constexpr double kStepPosition_m = 0.3;

struct SeenFrame {
  std::size_t row = 0;
  std::vector<SeenPoint> points;
};

/// The background's observations, by rows of Run::camera.
class BackgroundReader {
 public:
  BackgroundReader(const recording::Run& run, RunObservations& reader) : run_(run), reader_(reader) {
    for (std::size_t row = 0; row < run.camera.size(); ++row) {
      rows_.emplace(run.camera[row].frame, row);
    }
  }

  /// Appends rows below `end`, and the following one, as far as available.
  Status read_until(std::size_t end, std::size_t max_points, std::deque<SeenFrame>& frames) {
    std::size_t points = 0;
    for (const SeenFrame& frame : frames) {
      points += frame.points.size();
    }
    while (!is_over_ && next_row() < end && points < max_points) {
      const Result<std::span<const recording::Observation>> seen = reader_.next_frame();
      if (!seen) {
        return Unexpected(seen.error());
      }
      is_over_ = seen->empty();
      const auto row = is_over_ ? rows_.end() : rows_.find(seen->front().frame);
      if (!is_over_ && row == rows_.end() && run_.is_finished) {
        return fail(ErrorCode::kBadFormat, (run_.directory / "observations.bin").string() + ": frame " +
                                               std::to_string(seen->front().frame) +
                                               " is none of the run's; copy the run folder again");
      }
      if (row != rows_.end()) {
        frames.push_back({row->second, {}});
        last_row_ = row->second + 1;
        for (const recording::Observation& each : *seen) {
          if (each.track_id == 0) {
            frames.back().points.push_back({0, each.point_id, {each.u_left_px, each.v_px, each.u_right_px}});
          }
        }
        points += frames.back().points.size();
      }
    }
    return {};
  }
  /// Rows below this have been read.
  [[nodiscard]] std::size_t next_row() const { return last_row_; }
  [[nodiscard]] bool is_over() const { return is_over_; }

 private:
  const recording::Run& run_;
  RunObservations& reader_;
  std::unordered_map<std::int64_t, std::size_t> rows_;
  std::size_t last_row_ = 0;
  bool is_over_ = false;
};

class CameraRefinement {
 public:
  CameraRefinement(const recording::Run& run, const AdjustmentOptions& options) : run_(run), options_(options) {
    for (const recording::CameraRow& row : run.camera) {
      result_.T_world_cam.push_back(row.T_world_cam);
    }
  }

  Result<RefinedCamera> refine(BackgroundReader& reader, const std::function<void(std::size_t)>& progress) {
    std::deque<SeenFrame> frames;
    std::size_t first = 0;
    std::size_t kept = 1;  // Rows at the beginning of a stretch whose poses are fixed.
    const std::size_t rows = run_.camera.size();
    while (first < rows) {
      if (const Status read = reader.read_until(first + kMaxRows, kMaxObservations, frames); !read) {
        return Unexpected(read.error());
      }
      const bool is_last = reader.is_over() || reader.next_row() >= rows;
      const std::size_t end = is_last ? rows : reader.next_row();
      if (const Status refined = refine_stretch(first, end, kept, frames, is_last); !refined) {
        return Unexpected(refined.error());
      }
      progress(end);
      if (is_last) {
        break;
      }
      first = std::max(first + 1, end - std::min(end, kSharedRows));
      kept = kSharedRows / 2;
      while (!frames.empty() && frames.front().row < first) {
        frames.pop_front();
      }
    }
    return std::move(result_);
  }

 private:
  Status refine_stretch(std::size_t first, std::size_t end, std::size_t kept, const std::deque<SeenFrame>& frames,
                        bool is_last) {
    BodyProblem problem;
    problem.geometry = run_.rectified;
    problem.T_body_cam.assign(result_.T_world_cam.begin() + static_cast<std::ptrdiff_t>(first),
                              result_.T_world_cam.begin() + static_cast<std::ptrdiff_t>(end));
    for (const SeenFrame& frame : frames) {
      for (SeenPoint point : frame.points) {
        point.frame = static_cast<std::uint32_t>(frame.row - first);
        problem.seen.push_back(point);
      }
    }
    for (std::uint32_t k = 0; k < std::min(kept, end - first); ++k) {
      problem.fixed_frames.push_back(k);
    }
    Vector6d inverse_sigma;
    inverse_sigma << Eigen::Vector3d::Constant(1.0 / kStepRotation_rad),
        Eigen::Vector3d::Constant(1.0 / kStepPosition_m);
    for (std::size_t k = 1; k < problem.T_body_cam.size(); ++k) {
      const Se3 T_before_now = run_.camera[first + k - 1].T_world_cam.inverse() * run_.camera[first + k].T_world_cam;
      const auto now = static_cast<std::uint32_t>(k);
      problem.measured_steps.push_back({now - 1, now, T_before_now, inverse_sigma.asDiagonal()});
    }
    Result<BodyFit> fit = adjust_body(problem, options_);
    if (!fit) {
      return Unexpected(fit.error());
    }
    std::copy(problem.T_body_cam.begin(), problem.T_body_cam.end(),
              result_.T_world_cam.begin() + static_cast<std::ptrdiff_t>(first));
    result_.sigma_px = std::max(result_.sigma_px, fit->sigma_px);
    carry_on(end);
    keep_points(*fit, first, is_last ? end : end - std::min(end, kSharedRows));
    return {};
  }

  /// Rows that have not been adjusted continue from the adjusted ones by the run's steps.
  void carry_on(std::size_t end) {
    if (end < run_.camera.size() && end > 0) {
      const Se3 T_new_old = result_.T_world_cam[end - 1] * run_.camera[end - 1].T_world_cam.inverse();
      for (std::size_t row = end; row < run_.camera.size(); ++row) {
        result_.T_world_cam[row] = T_new_old * run_.camera[row].T_world_cam;
      }
    }
  }

  /// Of points that the next stretch does not see again.
  void keep_points(const BodyFit& fit, std::size_t first, std::size_t next_first) {
    for (RefinedPoint point : fit.points) {
      point.last_frame += static_cast<std::uint32_t>(first);
      if (point.last_frame < next_first) {
        result_.points.push_back(point);
      }
    }
  }

  const recording::Run& run_;
  const AdjustmentOptions& options_;
  RefinedCamera result_;
};

}  // namespace

Result<RefinedCamera> refine_camera(const recording::Run& run, const MeasuredBackground& measured,
                                    const AdjustmentOptions& options,
                                    const std::function<void(std::size_t)>& progress) {
  Result<RunObservations> observations = RunObservations::open(run, measured);
  if (!observations) {
    return Unexpected(observations.error());
  }
  BackgroundReader reader(run, *observations);
  return CameraRefinement(run, options).refine(reader, progress);
}

}  // namespace kinetrace::batch
