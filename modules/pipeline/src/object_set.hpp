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

/// An object that was lost and goes on in the slot of a new track.
struct ReidentifiedObject {
  std::uint8_t earlier_slot = 0;
  std::uint8_t slot = 0;
  std::uint32_t track_id = 0;
};

/// The objects of the tracker's tracks, from their masks to their trajectories. It never calls the tracker: what it
/// learns about a track's identity is returned, for the pipeline to pass on.
class ObjectSet {
 public:
  /// Errors: as sfm::BodyReconstruction::create. Sized once; nothing is allocated afterwards.
  [[nodiscard]] static Result<ObjectSet> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                                Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const PipelineConfig& config);

  /// The rig is corrected in another way from now on.
  void remeasure(const RigChange& change) noexcept;
  /// It was so far off that what was measured says nothing about how objects move.
  void restart_paths() noexcept;
  [[nodiscard]] std::span<ObjectState> slots() noexcept { return slots_; }
  [[nodiscard]] std::span<const ObjectState> slots() const noexcept { return slots_; }

  /// Where each object is expected to be seen, by slot.
  void prediction(std::int64_t timestamp_ns, const Se3& T_world_cam,
                  std::span<tracking::ObjectPrediction> by_slot) const;
  /// Begins the objects of new tracks, and ends those whose tracks have ended.
  void take_tracks(const TrackFrame& tracks);

  /// A detection shows the track, and where that is has never been known: it may be an object that was lost.
  [[nodiscard]] bool is_unplaced(const Track& track) const noexcept {
    return track.missed_frames == 0 && !slots_[track.slot].placed();
  }
  /// The track in this slot shows something else: the object waits in the slot of `waiting`, and a new one begins.
  void split(const Track& seen, const Track& waiting);
  /// Which of the unplaced tracks show objects that were lost, which then go on under them: one assignment over all of
  /// both, by log-likelihood ratios against new objects. Call once the other tracks have been observed. Lives until the
  /// next call.
  [[nodiscard]] std::span<const ReidentifiedObject> reidentify(std::span<const Track> tracks, const FeatureFrame& frame,
                                                               LabelView labels, const CameraState& camera);
  /// Whether an unplaced track may turn out to be an object that left the image.
  [[nodiscard]] bool may_be_lost_object(const Track& track, const CameraState& camera) const;
  /// Pose of this frame; false if the track has passed to another object.
  [[nodiscard]] bool observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera,
                             const features::FeatureFrontEnd& front_end);

  // Then, for all of them:

  /// Writes the bodies whose windows are to be adjusted and returns how many there are, at most one an object.
  [[nodiscard]] std::size_t list_windows(std::span<BodyRefinement> windows);
  /// `windows`: as listed, adjusted.
  void conclude(std::span<const BodyRefinement> windows, const CameraState& camera, const trajectory::Ground& ground);
  /// Takes note of what objects look like.
  void remember(const FeatureFrame& frame, const features::FeatureFrontEnd& front_end);
  /// The slots of objects that go on in another one or whose tracks have ended, once their points have been reported.
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
