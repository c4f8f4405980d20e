#include "evaluation/evaluate_input.hpp"

#include <limits>
#include <map>

#include "kinetrace/evaluation/camera_rotation.hpp"
#include "kinetrace/recording/mask_frames.hpp"
#include "study/mots_images.hpp"

namespace kinetrace::app {
namespace {

using evaluation::Association;
using evaluation::ImageBox;
using evaluation::LocatedObject;
using evaluation::MaskInstance;
using evaluation::ObjectFrame;
using recording::ObjectRow;

constexpr double kDegPerRad = 57.29577951308232;

/// The tracks of a frame, each with its row of objects.csv, its mask, or both.
struct RunFrame {
  std::int64_t frame = 0;
  std::map<std::uint32_t, const ObjectRow*> tracks;  ///< By id; null without a row.
};

evaluation::TrackEstimate estimate_of(const ObjectRow& row) {
  return {row.status, row.T_world_obj, row.box, row.box_sigma, row.velocity_mps, row.moving, row.heading_rad};
}

std::vector<ImageBox> track_boxes(const RunFrame& run_frame) {
  std::vector<ImageBox> boxes;
  for (const auto& [track_id, row] : run_frame.tracks) {
    boxes.push_back(row != nullptr ? ImageBox(row->mask_px) : ImageBox{});
  }
  return boxes;
}

std::vector<Eigen::Vector3d> track_centres(const RunFrame& run_frame) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3d> centres;
  for (const auto& [track_id, row] : run_frame.tracks) {
    centres.push_back(row != nullptr && row->status != BodyStatus::kLost ? row->box.center_m
                                                                         : Eigen::Vector3d::Constant(kNowhere));
  }
  return centres;
}

/// Builds the frames in order.
class Matcher {
 public:
  Matcher(const evaluation::Truth& truth, const StereoGeometry& rectified, recording::MaskFrames masks,
          const Se3& T_run_truth, double gate_m)
      : truth_(truth),
        rectified_(rectified),
        run_masks_(std::move(masks)),
        T_run_truth_(T_run_truth),
        gate_m_(gate_m) {}

  Result<ObjectFrame> match(RunFrame run_frame, const Se3& T_world_cam_true, Association association) {
    const Result<recording::MaskFrame> run_masks = run_masks_.at(run_frame.frame);
    if (!run_masks) {
      return Unexpected(run_masks.error());
    }
    for (const recording::FrameMask& mask : run_masks->masks) {
      run_frame.tracks.try_emplace(mask.track_id, nullptr);
    }
    ObjectFrame frame = frame_of(run_frame, T_world_cam_true);
    switch (association) {
      case Association::kMasks:
        if (const Status compared = compare_masks(*run_masks, run_frame, frame); !compared) {
          return Unexpected(compared.error());
        }
        break;
      case Association::kBoxes:
        evaluation::compare_boxes(true_boxes(frame.frame), track_boxes(run_frame), frame);
        break;
      case Association::kCentres:
        evaluation::compare_centres(true_centres(frame.frame), track_centres(run_frame), gate_m_, frame);
        break;
    }
    return frame;
  }

  [[nodiscard]] evaluation::MaskReport mask_report() const { return metrics_.report(); }

 private:
  const std::vector<LocatedObject>& objects_of(std::int64_t frame) const {
    static const std::vector<LocatedObject> none;
    const auto found = truth_.objects.find(frame);
    return found == truth_.objects.end() ? none : found->second;
  }

  ObjectFrame frame_of(const RunFrame& run_frame, const Se3& T_world_cam_true) const {
    ObjectFrame frame;
    frame.frame = run_frame.frame;
    frame.T_world_cam_true = T_run_truth_ * T_world_cam_true;
    for (const LocatedObject& located : objects_of(frame.frame)) {
      frame.truth.push_back(located.object);
      frame.truth.back().T_world_obj = T_run_truth_ * located.object.T_world_obj;
      frame.truth.back().center_m = T_run_truth_ * located.center_m;
      frame.truth.back().velocity_mps = T_run_truth_.rotation * located.object.velocity_mps;
    }
    for (const auto& [track_id, row] : run_frame.tracks) {
      frame.tracks.push_back({track_id, row != nullptr ? std::optional(estimate_of(*row)) : std::nullopt});
    }
    return frame;
  }

  std::vector<ImageBox> true_boxes(std::int64_t frame) const {
    std::vector<ImageBox> boxes;
    for (const LocatedObject& located : objects_of(frame)) {
      boxes.push_back(located.box_px);
    }
    return boxes;
  }

  std::vector<Eigen::Vector3d> true_centres(std::int64_t frame) const {
    std::vector<Eigen::Vector3d> centres;
    for (const LocatedObject& located : objects_of(frame)) {
      centres.push_back(T_run_truth_ * located.center_m);
    }
    return centres;
  }

  Status compare_masks(const recording::MaskFrame& run_masks, const RunFrame& run_frame, ObjectFrame& frame) {
    const std::optional<std::filesystem::path> path = mask_path(truth_, frame.frame);
    if (!path) {
      return fail(ErrorCode::kNotFound, truth_.mask_folder.string() + ": has no mask image of frame " +
                                            std::to_string(frame.frame) + "; copy the truth again");
    }
    const Result<evaluation::MotsImage> image = images_.read(*path, rectified_.width_px, rectified_.height_px);
    if (!image) {
      return Unexpected(image.error());
    }
    std::vector<MaskInstance> tracks;
    for (const recording::FrameMask& mask : run_masks.masks) {
      tracks.push_back({mask.label, mask.track_id, mask.class_id});
    }
    const evaluation::InstanceMasks tracked{run_masks.labels, tracks};
    if (const Status added = metrics_.add(image->masks(), tracked); !added) {
      return fail(added.error().code, path->string() + ": " + added.error().message);
    }
    // Objects are numbered by KITTI's instance numbers, which are unique across classes.
    constexpr std::int64_t kIdsPerClass = 1000;
    std::vector<MaskInstance> objects = image->instances;
    for (MaskInstance& object : objects) {
      object.id %= kIdsPerClass;
    }
    const Status compared =
        evaluation::compare_masks({image->masks().labels, objects}, tracked, track_boxes(run_frame), frame);
    return compared ? compared : fail(compared.error().code, path->string() + ": " + compared.error().message);
  }

  const evaluation::Truth& truth_;
  const StereoGeometry& rectified_;  ///< Of the run.
  recording::MaskFrames run_masks_;
  Se3 T_run_truth_;
  double gate_m_;
  MotsImages images_;
  evaluation::MaskMetrics metrics_;
};

Result<Association> best_association(const evaluation::Truth& truth, const recording::Run& run,
                                     std::optional<Association> wanted) {
  std::error_code error;
  const bool masks = !truth.mask_folder.empty() && std::filesystem::exists(run.directory / "mots.txt", error);
  if (wanted == Association::kMasks && !masks) {
    return fail(ErrorCode::kInvalidArgument,
                "masks cannot be compared: the run needs mots.txt (output.mots) and the "
                "truth mask images (--truth-masks)");
  }
  if (wanted == Association::kBoxes && !truth.has_boxes) {
    return fail(ErrorCode::kInvalidArgument, "boxes cannot be compared: this truth has none");
  }
  return wanted.value_or(masks ? Association::kMasks : truth.has_boxes ? Association::kBoxes : Association::kCentres);
}

std::vector<evaluation::PosePair> pair_cameras(const recording::Run& run, const evaluation::Truth& truth,
                                               std::int64_t time_tolerance_ns) {
  std::vector<evaluation::PosePair> pairs;
  for (const recording::CameraRow& row : run.camera) {
    if (const std::optional<Se3> truth_pose = truth.camera.at(row.frame, row.timestamp_ns, time_tolerance_ns)) {
      pairs.push_back({row.frame, *truth_pose, row.T_world_cam});
    }
  }
  return pairs;
}

// Frames and objects left out of the evaluation.
void add_notes(const recording::Run& run, const evaluation::Truth& truth, EvaluationInput& input) {
  if (input.camera.size() < run.camera.size()) {
    input.notes.push_back("the truth has a camera pose for " + std::to_string(input.camera.size()) + " of the run's " +
                          std::to_string(run.camera.size()) + " frames; the others do not count");
  }
  if (truth.has_objects && truth.objects.empty()) {
    input.notes.push_back("the truth has no object in any frame of the run");
  }
}

// EuRoC's ground truth refers to the raw camera, and a run does not record the rectifying rotation.
double turn_camera(std::vector<evaluation::PosePair>& pairs) {
  const Eigen::Matrix3d rotation = evaluation::camera_rotation(pairs);
  for (evaluation::PosePair& pair : pairs) {
    pair.T_world_cam.rotation *= rotation;
  }
  return so3_log(rotation).norm() * kDegPerRad;
}

}  // namespace

Result<EvaluationInput> match_up(const recording::Run& run, const evaluation::Truth& truth,
                                 std::int64_t time_tolerance_ns, std::optional<Association> association,
                                 double gate_m) {
  if (run.camera.empty()) {
    return fail(ErrorCode::kBadFormat, run.directory.string() + ": the run has no frame; there is nothing to evaluate");
  }
  EvaluationInput input;
  input.camera = pair_cameras(run, truth, time_tolerance_ns);
  if (input.camera.empty()) {
    return fail(ErrorCode::kBadFormat,
                run.directory.string() + ": no frame has a true camera pose; is this the truth of the same recording?");
  }
  add_notes(run, truth, input);
  if (truth.format == evaluation::TruthFormat::kEuroc) {
    input.camera_rotation_deg = turn_camera(input.camera);
  }
  if (!truth.has_objects) {
    return input;
  }
  const Result<Association> chosen = best_association(truth, run, association);
  if (!chosen) {
    return Unexpected(chosen.error());
  }
  input.association = *chosen;
  Result<recording::MaskFrames> masks = recording::MaskFrames::open(run);
  if (!masks) {
    return Unexpected(masks.error());
  }
  const evaluation::PosePair& first = input.camera.front();
  Matcher matcher(truth, run.rectified, std::move(*masks), first.T_world_cam * first.T_world_cam_true.inverse(),
                  gate_m);
  std::map<std::int64_t, RunFrame> run_frames;
  for (const ObjectRow& row : run.objects) {
    run_frames[row.frame].tracks[row.track_id] = &row;
  }
  for (const evaluation::PosePair& pair : input.camera) {
    run_frames[pair.frame].frame = pair.frame;
    Result<ObjectFrame> frame = matcher.match(run_frames[pair.frame], pair.T_world_cam_true, *chosen);
    if (!frame) {
      return Unexpected(frame.error());
    }
    input.objects.push_back(std::move(*frame));
  }
  if (*chosen == Association::kMasks) {
    input.masks = matcher.mask_report();
  }
  return input;
}

}  // namespace kinetrace::app
