#include "kinetrace/pipeline/pipeline.hpp"

#include <utility>

#include "camera/camera_tracker.hpp"
#include "camera/cut_detector.hpp"
#include "camera/rig_calibrator.hpp"
#include "feature_prediction.hpp"
#include "fixed_lag_results.hpp"
#include "frame_intake.hpp"
#include "frame_result_builder.hpp"
#include "frame_scratch.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"
#include "kinetrace/trajectory/ground_plane.hpp"
#include "object_set.hpp"
#include "resolved_config.hpp"
#include "window_refiner.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::int64_t kTrustedPrediction_ns = 200'000'000;  // Masks predicted for longer are unreliable.

/// Masks predicted for long: features in them may belong to another object.
features::FeatureFrontEnd::PredictedMasks predicted_masks(const TrackFrame& tracks) {
  features::FeatureFrontEnd::PredictedMasks predicted;
  for (const Track& track : tracks.tracks) {
    predicted[track.label()] = track.missed_ns > kTrustedPrediction_ns;
  }
  return predicted;
}

/// Motion of the camera since the previous frame.
struct EgoMotion {
  Se3 T_prev_cam;
  bool is_cut = false;  ///< There is a cut between the two frames.
};

}  // namespace

/// One of each stage, in the order of processing. Each uses the output of earlier ones; feedback to earlier ones
/// (outlier features, identities of tracks) takes effect in the next frame.
struct Pipeline::Impl {
  FrameIntake intake;
  RigCalibrator rig;
  features::FeatureFrontEnd front_end;
  std::unique_ptr<segmentation::Segmenter> segmenter;
  tracking::StereoTracker tracker;
  CameraTracker camera;
  trajectory::GroundEstimator ground;
  ObjectSet objects;
  WindowRefiner refiner;
  FixedLagResults results;
  FrameResultBuilder output;
  FrameScratch scratch;
  CutDetector cut_detector;
  std::span<const Feature> previous_features{};

  // The stages of a frame.
  /// Returns the pair with the right image as corrected.
  Result<RectifiedPair> take_in(const RectifiedPair& pair, StageObserver* observer);
  Result<FeatureFrame> track_features(std::int64_t timestamp_ns, StageObserver* observer);
  EgoMotion locate_camera(const FeatureFrame& frame, StageObserver* observer);
  Result<DetectionFrame> segment(const RectifiedPair& pair, const FeatureFrame& frame, const EgoMotion& ego,
                                 StageObserver* observer);
  Result<TrackFrame> track_objects(const DetectionFrame& detections, const FeatureFrame& frame,
                                   std::int64_t timestamp_ns, StageObserver* observer);
  Result<FeatureFrame> replenish(const TrackFrame& tracks, StageObserver* observer);
  void reconstruct(const FeatureFrame& frame, const TrackFrame& tracks, StageObserver* observer);
  /// The track in this slot was detected where its object cannot be.
  void split(std::uint8_t slot);
  /// Lists the slots of the tracks that `predicate` selects in scratch.slots.
  template <typename Predicate>
  void list_slots(const Predicate& predicate);
  Status refine(StageObserver* observer);
  void conclude(const RectifiedPair& pair, const TrackFrame& tracks, StageObserver* observer);
  /// State of this frame, with the uncertainty of the calibration.
  [[nodiscard]] CameraState camera_state() const;

  /// After a cut: all tracks end with this frame.
  void end_tracks();
  /// Drops the features that are outliers of their bodies.
  void reject_outliers();
  [[nodiscard]] FrameCounters counters() const;
};

Result<Pipeline> Pipeline::create(const PipelineConfig& config, const StereoGeometry& geometry, Arena& arena,
                                  const MaskMakers& makers, Workers* workers) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const PipelineConfig c = resolved(config);
  auto rig = RigCalibrator::create(c, geometry, arena);
  if (!rig) {
    return Unexpected(rig.error());
  }
  auto front_end = features::FeatureFrontEnd::create(c.features, geometry.width_px, geometry.height_px, arena, workers);
  if (!front_end) {
    return Unexpected(front_end.error());
  }
  auto segmenter =
      segmentation::make_segmenter(c.segmentation, geometry, c.features.max_features, arena, makers, workers);
  if (!segmenter) {
    return Unexpected(segmenter.error());
  }
  auto tracker = tracking::StereoTracker::create(c.tracking, geometry.width_px, geometry.height_px, arena);
  if (!tracker) {
    return Unexpected(tracker.error());
  }
  auto background = sfm::BodyReconstruction::create(c.background, geometry, arena);
  if (!background) {
    return Unexpected(background.error());
  }
  auto objects = ObjectSet::create(c, geometry, arena);
  if (!objects) {
    return Unexpected(objects.error());
  }
  auto refiner = WindowRefiner::create(c.refinement, c.object, arena, workers);
  if (!refiner) {
    return Unexpected(refiner.error());
  }
  // Named members need the aggregate itself.  NOLINTNEXTLINE(modernize-make-unique)
  std::unique_ptr<Impl> impl(
      new Impl{.intake = FrameIntake(geometry),
               .rig = *rig,
               .front_end = std::move(*front_end),
               .segmenter = std::move(*segmenter),
               .tracker = *tracker,
               .camera = CameraTracker(*background),
               .ground = trajectory::GroundEstimator(static_cast<std::size_t>(c.background.max_points), arena),
               .objects = std::move(*objects),
               .refiner = std::move(*refiner),
               .results = FixedLagResults(c, arena),
               .output = FrameResultBuilder(c, arena),
               .scratch = FrameScratch(c, arena),
               // All tracks would be forgotten by then.
               .cut_detector = CutDetector(c.tracking.max_missed_s + c.tracking.max_unseen_s)});
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the pipeline; size it from Pipeline::plan");
  }
  return Pipeline(std::move(impl));
}

Pipeline::Pipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

Result<const FrameResult*> Pipeline::process(const RectifiedPair& given, StageObserver* observer) {
  Impl& self = *impl_;
  if (const Status valid = self.intake.check(given); !valid) {
    return Unexpected(valid.error());
  }
  const Result<RectifiedPair> corrected = self.take_in(given, observer);
  if (!corrected) {
    return Unexpected(corrected.error());
  }
  const RectifiedPair& pair = *corrected;
  const Result<FeatureFrame> tracked = self.track_features(pair.timestamp_ns, observer);
  if (!tracked) {
    return Unexpected(tracked.error());
  }
  const EgoMotion ego = self.locate_camera(*tracked, observer);
  const Result<DetectionFrame> detections = self.segment(pair, *tracked, ego, observer);
  if (!detections) {
    return Unexpected(detections.error());
  }
  const Result<TrackFrame> tracks = self.track_objects(*detections, *tracked, pair.timestamp_ns, observer);
  if (!tracks) {
    return Unexpected(tracks.error());
  }
  const Result<FeatureFrame> frame = self.replenish(*tracks, observer);
  if (!frame) {
    return Unexpected(frame.error());
  }
  self.reconstruct(*frame, *tracks, observer);
  if (const Status refined = self.refine(observer); !refined) {
    return Unexpected(refined.error());
  }
  self.rig.observe(*frame, self.camera, ego.is_cut);
  self.conclude(pair, *tracks, observer);
  return &self.output.result();
}

void Pipeline::limit(const Effort& effort) noexcept {
  impl_->front_end.limit(effort.points);
  impl_->tracker.limit(effort.objects);
  impl_->refiner.limit(effort.refinement_iterations);
}

Result<RectifiedPair> Pipeline::Impl::take_in(const RectifiedPair& pair, StageObserver* observer) {
  RectifiedPair corrected = pair;
  {
    const StageScope pyramid(observer, Stage::kPyramid);
    rig.begin_frame(pair.timestamp_ns);
    const features::RigAdjustment adjustment = rig.adjustment();
    if (rig.change() != nullptr) {
      camera.background().remeasure(*rig.change());
      objects.remeasure(*rig.change());
    }
    if (const Status begun = front_end.begin_frame(pair, adjustment); !begun) {
      return Unexpected(begun.error());
    }
    if (!adjustment.correction.is_zero()) {
      corrected.right = front_end.right_image();
    }
  }
  const StageScope capture(observer, Stage::kCapture);
  segmenter->load(corrected, tracker.tracks());
  return corrected;
}

Result<FeatureFrame> Pipeline::Impl::track_features(std::int64_t timestamp_ns, StageObserver* observer) {
  const StageScope stage(observer, Stage::kTrackFeatures);
  predict_features(previous_features, camera.background(), objects.slots(), timestamp_ns, scratch.predictions);
  return front_end.track(scratch.predictions);
}

EgoMotion Pipeline::Impl::locate_camera(const FeatureFrame& frame, StageObserver* observer) {
  const StageScope stage(observer, Stage::kEgoMotion);
  const bool is_cut = cut_detector.is_cut(frame, previous_features.size(), front_end);
  EgoMotion ego{camera.locate(frame, frame.timestamp_ns - intake.last_timestamp_ns(), is_cut), is_cut};
  if (rig.must_restart() || front_end.row_search_began()) {
    camera.restart_map();
  }
  if (rig.must_restart_paths()) {
    objects.restart_paths();
  }
  if (is_cut) {
    end_tracks();
    ground.reset();
  }
  return ego;
}

CameraState Pipeline::Impl::camera_state() const {
  CameraState now = camera.state(0);
  rig.add_uncertainty(now);
  now.vertical = ground.ground().vertical();
  return now;
}

void Pipeline::Impl::end_tracks() {
  for (std::size_t slot = 0; slot < objects.slots().size(); ++slot) {
    tracker.terminate(static_cast<std::uint8_t>(slot));
  }
}

Result<DetectionFrame> Pipeline::Impl::segment(const RectifiedPair& pair, const FeatureFrame& frame,
                                               const EgoMotion& ego, StageObserver* observer) {
  const StageScope stage(observer, Stage::kSegment);
  return segmenter->process({.pair = pair,
                             .features = frame.features,
                             .ego_valid = intake.frames() > 0 && camera.tracked(),
                             .T_prev_cam = ego.T_prev_cam,
                             .is_cut = ego.is_cut});
}

Result<TrackFrame> Pipeline::Impl::track_objects(const DetectionFrame& detections, const FeatureFrame& frame,
                                                 std::int64_t timestamp_ns, StageObserver* observer) {
  const StageScope stage(observer, Stage::kTrackObjects);
  objects.predict(timestamp_ns, camera.background().estimate().T_body_cam, scratch.object_predictions);
  Result<TrackFrame> tracks = tracker.process(timestamp_ns, detections, frame.features, scratch.object_predictions);
  if (tracks) {
    objects.take_tracks(*tracks);
  }
  return tracks;
}

Result<FeatureFrame> Pipeline::Impl::replenish(const TrackFrame& tracks, StageObserver* observer) {
  const StageScope stage(observer, Stage::kReplenish);
  Result<FeatureFrame> frame = front_end.replenish(tracks.left_labels, predicted_masks(tracks));
  if (frame) {
    previous_features = frame->features;
  }
  return frame;
}

// Decides identities: a track that shows another object is split, new tracks may be lost objects.
void Pipeline::Impl::reconstruct(const FeatureFrame& frame, const TrackFrame& tracks, StageObserver* observer) {
  const StageScope stage(observer, Stage::kSfm);
  camera.extend(frame);
  const CameraState now = camera_state();
  const auto observe = [&](std::uint8_t slot) {
    return objects.observe(tracker.track_in(slot), frame, tracks.left_labels, now);
  };
  list_slots([&](const Track& track) { return !objects.is_detected_without_position(track); });
  for (const std::uint8_t slot : scratch.slots) {
    if (!observe(slot)) {
      split(slot);
    }
  }
  list_slots([&](const Track& track) { return objects.is_detected_without_position(track); });
  for (const ReidentifiedObject& found : objects.reidentify(tracker.tracks(), frame, tracks.left_labels, now)) {
    tracker.merge_tracks(found.earlier_slot, found.slot);
    results.move_slot(found.track_id, found.slot);
  }
  for (const std::uint8_t slot : scratch.slots) {
    if (!observe(slot)) {
      tracker.terminate(slot);
    }
  }
}

void Pipeline::Impl::split(std::uint8_t slot) {
  const Track track = objects.slots()[slot].track_before();
  if (const std::optional<std::uint8_t> dormant = tracker.split_track(slot, track)) {
    objects.split(tracker.track_in(slot), tracker.track_in(*dormant));
    results.move_slot(track.id, *dormant);
  } else {
    tracker.terminate(slot);
  }
}

template <typename Predicate>
void Pipeline::Impl::list_slots(const Predicate& predicate) {
  scratch.slots.clear();
  for (const Track& track : tracker.tracks()) {
    if (predicate(track)) {
      (void)scratch.slots.push_back(track.slot);  // as many places as slots
    }
  }
}

Status Pipeline::Impl::refine(StageObserver* observer) {
  const StageScope stage(observer, Stage::kRefine);
  const std::span<BodyRefinement> bodies =
      scratch.refinements.first(1 + objects.list_windows(scratch.refinements.subspan(1)));
  bodies[0] = {&camera.background(), {}};
  if (Status refined = refiner.refine(bodies); !refined) {
    return refined;
  }
  camera.background().conclude(bodies[0].summary);
  const CameraState now = camera_state();
  if (now.valid) {
    ground.update(camera.background().estimate().points, now.T_world_cam);
  }
  objects.conclude(bodies.subspan(1), now, ground.ground());
  return {};
}

void Pipeline::Impl::conclude(const RectifiedPair& pair, const TrackFrame& tracks, StageObserver* observer) {
  const StageScope stage(observer, Stage::kTrajectory);
  intake.count(pair);
  results.push(pair, objects.slots());
  results.revise(camera, ground.ground().vertical(), objects.slots());
  output.set_newest(results.newest());
  output.set_finalised(results.finalise());
  output.set_bodies(camera.background(), objects.slots());
  output.set_tracks(tracker.tracks(), objects.slots());
  objects.release();
  output.set_frame(pair, tracks, counters());
  output.set_rig(rig.estimate());
  reject_outliers();
}

void Pipeline::Impl::reject_outliers() {
  front_end.reject(camera.background().rejected_slots());
  for (const ObjectState& object : objects.slots()) {
    if (object.in_use()) {
      front_end.reject(object.body().rejected_slots());
    }
  }
}

FrameCounters Pipeline::Impl::counters() const {
  const features::FeatureCounters& f = front_end.counters();
  const segmentation::SegmentationCounters& s = segmenter->counters();
  FrameCounters c;
  c.frames = intake.frames();
  c.features_tracked = f.tracked;
  c.features_lost = f.lost();
  c.features_created = f.created;
  c.features_dropped = f.dropped;
  c.stereo_matched = f.stereo_matched;
  c.detections = s.detections;
  c.detections_dropped = s.detections_dropped + tracker.counters().detections_dropped;
  c.detection_frames_missing = s.frames_missing + s.frames_unreadable;
  c.mask_files_unreadable = s.files_unreadable;
  c.tracks_born = tracker.counters().born;
  c.tracks_confirmed = tracker.counters().confirmed;
  c.tracks_ended = tracker.counters().ended;
  c.background_lost_frames = camera.lost_frames();
  const auto add_points = [&c](const sfm::BodyCounters& body) {
    c.points_created += body.points_created;
    c.points_culled += body.points_culled;
    c.points_dropped += body.points_dropped;
  };
  add_points(camera.background().counters());
  for (const ObjectState& object : objects.slots()) {
    add_points(object.body().counters());
  }
  return c;
}

std::string_view Pipeline::mask_complaint() const noexcept {
  const segmentation::Segmenter& segmenter = *impl_->segmenter;
  return segmenter.warning_count() > 0 ? segmenter.warning(0) : std::string_view();
}

const FrameResult* Pipeline::drain() {
  Impl& self = *impl_;
  if (self.intake.close()) {
    self.camera.end();
    self.objects.end();
    self.output.set_bodies(self.camera.background(), self.objects.slots());
    self.output.clear_frame();
  } else {
    self.output.clear_bodies();
  }
  const BufferedFrame* const finalised = self.results.drain();
  if (finalised == nullptr) {
    return nullptr;
  }
  self.output.set_finalised(finalised);
  return &self.output.result();
}

}  // namespace kinetrace::pipeline
