// Errors of an object's reconstruction, frame by frame.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {

/// Errors of one object in one frame; none: not measurable.
///
/// Errors of the object's reconstruction alone, relative to the camera: the true camera transforms estimates into the
/// world, before smoothing. Poses are finalised; points are those observed in the newest frame and an earlier one, as
/// estimated then.
struct StudyRow {
  std::int64_t frame = 0;
  std::uint32_t object_id = 0;
  double distance_m = 0.0;  ///< From the camera to the centre of the object's box.
  int height_px = 0;        ///< Height of the visible part of the object.
  std::uint32_t track_id =
      0;  ///< 0: no track's mask overlaps the object's mask with an intersection over union of a half.
  BodyStatus status = BodyStatus::kLost;
  int points = 0;  ///< Points of known true depth.
  /// Distance of the box centre from the truth, after the constant offset in the object's frame that fits the whole
  /// track best (least squares, weighted by distance^-4 as stereo's variance grows).
  std::optional<double> position_m = {};
  std::optional<double> center_m = {};    ///< Distance of the estimated box's centre from the true one; no offset.
  std::optional<double> motion_m = {};    ///< From the frame before, in the true body frame; see ObjectErrors::motion.
  std::optional<double> motion_deg = {};  ///< ... its rotation.
  std::optional<double> depth_bias_m = {};  ///< Median over the points of depth minus true depth: no offset.
  std::optional<double> depth_m = {};       ///< Median over the points of the magnitude of the same difference.
  std::optional<double> shape_m = {};       ///< ... after removal of the bias.
  std::optional<double> wrong_points = {};  ///< Share of the points with an error above a fifth of the distance.
  /// Errors of the published, smoothed path with the estimated camera, of any status but lost: as
  /// ObjectErrors::distance_m and ObjectErrors::motion.
  std::optional<double> published_place_m = {};
  std::optional<double> published_motion_m = {};
  std::optional<double> published_motion_deg = {};
};

/// Compares the results of one run, in order, with ground truth.
class StudyErrors {
 public:
  /// `truth` outlives the object.
  explicit StudyErrors(StudyTruth& truth) : truth_(truth) {}

  /// Errors: those of the truth's images; kInvalidArgument (the run's images have another size).
  [[nodiscard]] Status add(const FrameResult& result);
  /// All rows, by object and frame. Call after the pipeline has been drained.
  [[nodiscard]] std::vector<StudyRow> rows() const;

 private:
  struct Sample {
    StudyRow row;
    evaluation::LocatedObject truth;
    Se3 T_world_cam_true;
    std::optional<Se3> T_world_obj;  ///< If tracked.
    std::optional<Se3> published;    ///< If not lost.
  };
  using Key = std::pair<std::uint32_t, std::int64_t>;  ///< Object, frame.

  [[nodiscard]] Status begin_frame(const FrameResult& result);
  void finalise(const FrameEstimate& finalised);
  /// Whether the samples are consecutive, on the same track.
  [[nodiscard]] static bool consecutive(const Sample& before, const Sample& after);
  void measure_published(std::vector<StudyRow>& rows) const;

  StudyTruth& truth_;
  std::map<Key, Sample> samples_;
};

}  // namespace kinetrace::app
