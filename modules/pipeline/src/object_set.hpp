// All objects, by track slot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/tracking/assignment.hpp"
#include "object_state.hpp"
#include "window_refiner.hpp"

namespace kinetrace::pipeline {

/// A lost object that continues in the slot of a new track.
struct ReidentifiedObject {
  std::uint8_t earlier_slot = 0;
  std::uint8_t slot = 0;
  std::uint32_t track_id = 0;
};

/// The objects of the tracker's tracks, from their masks to their trajectories. It never calls the tracker: decisions
/// on the identity of tracks are returned, for the pipeline to pass on.
class ObjectSet {
 public:
  /// Errors: as sfm::BodyReconstruction::create. Sized once; nothing is allocated afterwards.
  [[nodiscard]] static Result<ObjectSet> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  /// Converts measurements to a changed correction of the rig.
  void remeasure(const RigChange& change) noexcept;
  /// The rig was so far off that earlier positions are no evidence of motion.
  void restart_paths() noexcept;
  [[nodiscard]] std::span<ObjectState> slots() noexcept { return slots_; }
  [[nodiscard]] std::span<const ObjectState> slots() const noexcept { return slots_; }

  /// Where each object is expected to be seen, by slot.
  void predict(std::int64_t timestamp_ns, const Se3& T_world_cam, std::span<tracking::ObjectPrediction> by_slot) const;
  /// Begins the objects of new tracks, and ends those whose tracks have ended.
  void take_tracks(const TrackFrame& tracks);

  /// A detected track whose position has never been known: it may be a lost object.
  [[nodiscard]] bool is_detected_without_position(const Track& track) const noexcept {
    return track.missed_frames == 0 && !slots_[track.slot].has_position();
  }
  /// The detection of `detected` belongs to another object, which begins in its slot; the old object stays dormant in
  /// the slot of `dormant`.
  void split(const Track& detected, const Track& dormant);
  /// Associates tracks without a position with lost objects, which then continue in the slots of those tracks: one
  /// assignment over all pairs, by log-likelihood ratios against new objects. Call once the other tracks have been
  /// observed. Valid until the next call.
  [[nodiscard]] std::span<const ReidentifiedObject> reidentify(std::span<const Track> tracks, const FeatureFrame& frame,
                                                               LabelView labels, const CameraState& camera);
  /// Pose of this frame; false if the track has switched to another object.
  [[nodiscard]] bool observe(const Track& track, const FeatureFrame& frame, LabelView labels,
                             const CameraState& camera);

  // Then, for all of them:

  /// Writes the bodies whose windows are to be adjusted and returns how many there are, at most one per object.
  [[nodiscard]] std::size_t list_windows(std::span<BodyRefinement> windows);
  /// `windows`: as listed, adjusted.
  void conclude(std::span<const BodyRefinement> windows, const CameraState& camera, const trajectory::Ground& ground);
  /// Frees the slots of objects that ended or continue in another slot, once their points have been reported.
  void release();
  /// No more frames.
  void end();

 private:
  ObjectSet(std::vector<ObjectState> slots, int min_features, Arena& arena)
      : slots_(std::move(slots)), min_features_(min_features), reidentified_(arena, slots_.size()) {}
  std::vector<ObjectState> slots_;
  int min_features_;                   ///< Of a position by stereo.
  tracking::AffinityMatrix affinity_;  ///< Lost object by new track, both by slot.
  FixedVector<ReidentifiedObject> reidentified_;
};

}  // namespace kinetrace::pipeline
