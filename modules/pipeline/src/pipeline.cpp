#include "kinetrace/pipeline/pipeline.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "jump_watch.hpp"
#include "kept_paths.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"
#include "object_state.hpp"
#include "result_ring.hpp"
#include "window_refiner.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::uint8_t kBackground = kBackgroundLabel;
constexpr std::int64_t kCameraLostAfter_ns = 200'000'000;
// Frames that are final but still say how an object has moved into the window.
constexpr std::size_t kSettledFramesKept = 2;
constexpr std::int64_t kTrustedPrediction_ns = 200'000'000;  // Masks predicted for longer are guesses.

std::size_t as_size(int n) {
  return static_cast<std::size_t>(n);
}

/// Fills in what follows from other settings, so that each is set once.
PipelineConfig resolved(const PipelineConfig& config) {
  PipelineConfig out = config;
  out.background.max_features = out.features.max_features;
  out.object.max_features = out.features.max_features;
  if (out.segmentation.mode == segmentation::SegmentationMode::kMotion) {
    out.features.bucket_px = out.motion_bucket_px;
  }
  out.refinement.max_frames = out.background.window_frames;
  out.refinement.max_points = std::max(out.background.max_points, out.object.max_points);
  return out;
}

/// The results that one frame shows to the outside, besides the ring.
struct OutputStorage {
  std::span<FeaturePrediction> predictions;
  std::span<tracking::Forecast> forecasts;
  std::span<ObjectResult> newest_objects;
  std::span<ObjectResult> settled_objects;
  std::span<BodyGeometry> bodies;
  std::span<BodyRefinement> refinements;
  ResultRing ring;
};

std::size_t ring_frames(const PipelineConfig& config) {
  return as_size(config.background.window_frames) + 1 + kSettledFramesKept;
}

/// Predicted masks: what lies in them may be something else.
features::FeatureFrontEnd::GuessedMasks guessed_masks(const TrackFrame& tracks) {
  features::FeatureFrontEnd::GuessedMasks guessed;
  for (const Track& track : tracks.tracks) {
    guessed[track.label()] = track.missed_ns > kTrustedPrediction_ns;
  }
  return guessed;
}

OutputStorage carve_output(const PipelineConfig& config, Arena& arena) {
  const std::size_t objects = as_size(config.tracking.max_objects);
  const std::size_t frames = ring_frames(config);
  return {.predictions = arena.take<FeaturePrediction>(as_size(config.features.max_features)),
          .forecasts = arena.take<tracking::Forecast>(objects),
          .newest_objects = arena.take<ObjectResult>(objects),
          .settled_objects = arena.take<ObjectResult>(objects),
          .bodies = arena.take<BodyGeometry>(objects + 1),
          .refinements = arena.take<BodyRefinement>(objects + 1),
          .ring = ResultRing(arena, frames, objects)};
}

}  // namespace

struct Pipeline::Impl {
  PipelineConfig config;
  StereoGeometry geometry;
  features::FeatureFrontEnd front_end;
  std::unique_ptr<segmentation::Segmenter> segmenter;
  tracking::StereoTracker tracker;
  sfm::BodyReconstruction background;
  std::vector<ObjectState> objects;  // By track slot; sized once, at create.
  WindowRefiner refiner;
  KeptPaths paths;
  OutputStorage out;
  JumpWatch jump_watch{};
  std::size_t unsettled = 0;  ///< Newest frames of the ring that have not been given out as settled.

  FrameResult result{};
  std::span<const Feature> previous_features{};
  std::int64_t last_timestamp_ns = 0;
  bool started = false;
  bool drained = false;
  DwellTime camera_predicted{};
  std::uint64_t frames = 0;
  std::uint64_t camera_lost_frames = 0;
  std::uint64_t tracks_born = 0;
  std::uint64_t tracks_confirmed = 0;
  std::uint64_t tracks_ended = 0;
  std::uint32_t newest_track_id = 0;

  Status check(const RectifiedPair& pair) const;
  std::span<const FeaturePrediction> predict_features(std::int64_t timestamp_ns);
  /// `jumped`: the frame shows something else than the one before it.
  Se3 locate_camera(const FeatureFrame& frame, bool jumped);
  /// What has been seen is no longer there: all tracks end with this frame.
  void forget_objects();
  std::span<const tracking::Forecast> forecast_objects(std::int64_t timestamp_ns);
  /// Something that was lost from sight, or hidden, keeps its name when it is seen again: whether it is.
  bool find_again(ObjectState& reborn, const Track& track, const FeatureFrame& frame, LabelView labels,
                  const CameraState& camera);
  /// A new track may turn out to be something that left the image.
  [[nodiscard]] bool may_come_back(const Track& reborn, const CameraState& camera) const;
  void reconstruct(const FeatureFrame& frame, const TrackFrame& tracks);
  Status refine();
  void count_tracks(const TrackFrame& tracks);
  void settle(const RectifiedPair& pair);
  void revise_ring();
  void smooth_paths();
  void publish_settled();
  void publish(const RectifiedPair& pair, const TrackFrame& tracks);
  void publish_bodies(const TrackFrame* tracks);
  void report_rejected();
  [[nodiscard]] CameraState camera_at(std::size_t age) const;
  [[nodiscard]] CameraResult camera_result(std::size_t age) const;
  [[nodiscard]] FrameCounters counters() const;
};

Result<MemoryPlan> Pipeline::plan(const PipelineConfig& config, const StereoGeometry& geometry) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const PipelineConfig c = resolved(config);
  const std::size_t object_bytes = ObjectState::required_bytes(c);
  MemoryPlan plan;
  plan.entries = {
      {"features", features::FeatureFrontEnd::required_bytes(c.features, geometry.width_px, geometry.height_px),
       "image size, features.max_features, features.pyramid_levels"},
      {"segmentation", segmentation::required_bytes(c.segmentation, geometry, c.features.max_features),
       "image size, segmentation.mode, segmentation.max_objects"},
      {"tracking", tracking::StereoTracker::required_bytes(c.tracking, geometry.width_px, geometry.height_px),
       "image size, tracking.max_objects"},
      {"background", sfm::BodyReconstruction::required_bytes(c.background),
       "background.max_points, background.window_frames"},
      {"objects", object_bytes * as_size(c.tracking.max_objects),
       "tracking.max_objects, object.max_points, object.window_frames"},
      {"refinement", WindowRefiner::required_bytes(c.refinement, c.object),
       "background.max_points, background.window_frames, object.max_points"},
      {"results", measure_bytes([&](Arena& arena) {
         static_cast<void>(KeptPaths(c.trajectory, ring_frames(c), arena));
         static_cast<void>(carve_output(c, arena));
       }),
       "tracking.max_objects, background.window_frames"},
  };
  return plan;
}

Result<Pipeline> Pipeline::create(const PipelineConfig& config, const StereoGeometry& geometry, Arena& arena,
                                  const MaskMakers& makers, Workers* workers) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const PipelineConfig c = resolved(config);
  auto front_end = features::FeatureFrontEnd::create(c.features, geometry.width_px, geometry.height_px, arena, workers);
  if (!front_end) {
    return Unexpected(front_end.error());
  }
  auto segmenter = segmentation::make_segmenter(c.segmentation, geometry, c.features.max_features, arena, makers);
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
  std::vector<ObjectState> objects;
  objects.reserve(as_size(c.tracking.max_objects));
  for (int i = 0; i < c.tracking.max_objects; ++i) {
    auto object = ObjectState::create(c, geometry, arena);
    if (!object) {
      return Unexpected(object.error());
    }
    objects.push_back(std::move(*object));
  }
  auto refiner = WindowRefiner::create(c.refinement, c.object, arena, workers);
  if (!refiner) {
    return Unexpected(refiner.error());
  }
  const KeptPaths paths(c.trajectory, ring_frames(c), arena);
  const OutputStorage out = carve_output(c, arena);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the pipeline; size it from Pipeline::plan");
  }
  // Named members need the aggregate itself.  NOLINTNEXTLINE(modernize-make-unique)
  return Pipeline(std::unique_ptr<Impl>(new Impl{.config = c,
                                                 .geometry = geometry,
                                                 .front_end = std::move(*front_end),
                                                 .segmenter = std::move(*segmenter),
                                                 .tracker = *tracker,
                                                 .background = *background,
                                                 .objects = std::move(objects),
                                                 .refiner = std::move(*refiner),
                                                 .paths = paths,
                                                 .out = out}));
}

Pipeline::Pipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
Pipeline::~Pipeline() = default;

Result<const FrameResult*> Pipeline::process(const RectifiedPair& pair, StageObserver* observer) {
  Impl& self = *impl_;
  if (const Status valid = self.check(pair); !valid) {
    return Unexpected(valid.error());
  }
  {
    const StageScope capture(observer, Stage::kCapture);
    self.segmenter->load(pair, self.tracker.tracks());
  }
  Result<FeatureFrame> frame;
  {
    const StageScope pyramid(observer, Stage::kPyramid);
    if (const Status begun = self.front_end.begin_frame(pair); !begun) {
      return Unexpected(begun.error());
    }
  }
  {
    const StageScope track(observer, Stage::kTrackFeatures);
    frame = self.front_end.track(self.predict_features(pair.timestamp_ns));
    if (!frame) {
      return Unexpected(frame.error());
    }
  }
  Se3 T_prev_cam;
  bool jumped = false;
  {
    const StageScope ego_motion(observer, Stage::kEgoMotion);
    jumped = self.jump_watch.has_jumped(*frame, self.previous_features.size(), self.front_end);
    T_prev_cam = self.locate_camera(*frame, jumped);
    if (jumped) {
      self.forget_objects();
    }
  }
  Result<DetectionFrame> detections;
  {
    const StageScope segment(observer, Stage::kSegment);
    detections =
        self.segmenter->process({.pair = pair,
                                 .features = frame->features,
                                 .ego_valid = self.started && self.background.estimate().status == BodyStatus::kTracked,
                                 .T_prev_cam = T_prev_cam,
                                 .jumped = jumped});
    if (!detections) {
      return Unexpected(detections.error());
    }
  }
  Result<TrackFrame> tracks;
  {
    const StageScope track(observer, Stage::kTrackObjects);
    tracks =
        self.tracker.process(pair.timestamp_ns, *detections, frame->features, self.forecast_objects(pair.timestamp_ns));
    if (!tracks) {
      return Unexpected(tracks.error());
    }
    self.count_tracks(*tracks);
  }
  {
    const StageScope replenish(observer, Stage::kReplenish);
    frame = self.front_end.replenish(tracks->left_labels, guessed_masks(*tracks));
    if (!frame) {
      return Unexpected(frame.error());
    }
    self.previous_features = frame->features;
  }
  {
    const StageScope sfm(observer, Stage::kSfm);
    self.reconstruct(*frame, *tracks);
  }
  {
    const StageScope refine(observer, Stage::kRefine);
    if (const Status refined = self.refine(); !refined) {
      return Unexpected(refined.error());
    }
    for (ObjectState& object : self.objects) {
      if (object.alive()) {
        object.remember(*frame, self.front_end);
      }
    }
  }
  const StageScope trajectory(observer, Stage::kTrajectory);
  self.started = true;
  ++self.frames;
  self.last_timestamp_ns = pair.timestamp_ns;
  self.settle(pair);
  self.publish(pair, *tracks);
  self.report_rejected();
  return &self.result;
}

void Pipeline::limit(const Effort& effort) noexcept {
  impl_->front_end.limit(effort.points);
  impl_->tracker.limit(effort.objects);
  impl_->refiner.limit(effort.refinement_iterations);
}

Status Pipeline::Impl::check(const RectifiedPair& pair) const {
  for (const GrayView& eye : {pair.left, pair.right}) {
    if (eye.empty() || eye.width != geometry.width_px || eye.height != geometry.height_px) {
      return fail(ErrorCode::kInvalidArgument, "frame " + std::to_string(pair.frame_index) + " has an image of " +
                                                   std::to_string(eye.width) + "x" + std::to_string(eye.height) +
                                                   ", the pipeline was made for " + std::to_string(geometry.width_px) +
                                                   "x" + std::to_string(geometry.height_px));
    }
  }
  if (started && pair.timestamp_ns <= last_timestamp_ns) {
    return fail(ErrorCode::kInvalidArgument,
                "frame " + std::to_string(pair.frame_index) +
                    " is not later than the frame before it; give frames in order of time");
  }
  if (drained) {
    return fail(ErrorCode::kIllegalState, "the pipeline has been drained; make a new one for another sequence");
  }
  return {};
}

std::span<const FeaturePrediction> Pipeline::Impl::predict_features(std::int64_t timestamp_ns) {
  std::fill(out.predictions.begin(), out.predictions.end(), FeaturePrediction{});
  background.predict_features(previous_features, kBackground, timestamp_ns, out.predictions);
  for (const ObjectState& object : objects) {
    if (!object.in_use()) {
      continue;
    }
    // Until an object has shown how it moves, it is taken to stand still in the world.
    const sfm::BodyReconstruction& body = object.body().history_size() < 2 ? background : object.body();
    body.predict_features(previous_features, object.track().label(), timestamp_ns, out.predictions);
  }
  // What no body explains (a body without motion yet, a mover not yet told from the background) goes on as it went in
  // the image.
  for (const Feature& feature : previous_features) {
    const bool unexplained = feature.body == kBackground && !background.agreed(feature);
    FeaturePrediction& prediction = out.predictions[feature.slot];
    if (feature.age_frames > 0 && (unexplained || !prediction.known)) {
      prediction = {.left_px = 2.F * feature.left_px - feature.previous_left_px,
                    .disparity_px = feature.has_right() ? feature.disparity_px() : -1.F,
                    .known = true};
    }
  }
  return out.predictions;
}

Se3 Pipeline::Impl::locate_camera(const FeatureFrame& frame, bool jumped) {
  if (!background.active()) {
    background.begin(Se3{});
    return {};
  }
  const Se3 T_world_prev = background.history(0).T_body_cam;
  const bool found = background.locate(frame, kBackground).status == BodyStatus::kTracked;
  if (found && !jumped) {
    camera_predicted.reset();
  } else {
    if (found) {
      // What seemed to be seen again is something else that looks like it.
      background.refuse_pose();
    }
    camera_predicted.add_frame(frame.timestamp_ns - last_timestamp_ns);
    ++camera_lost_frames;
    // Known points no longer fit: a new map starts at the predicted pose with this frame's stereo.
    background.begin(background.estimate().T_body_cam,
                     camera_predicted.exceeds(kCameraLostAfter_ns) ? BodyStatus::kLost : BodyStatus::kPropagated);
    if (jumped) {
      background.forget_motion();
    }
  }
  return T_world_prev.inverse() * background.estimate().T_body_cam;
}

void Pipeline::Impl::forget_objects() {
  for (std::size_t slot = 0; slot < objects.size(); ++slot) {
    tracker.abandon(static_cast<std::uint8_t>(slot));
  }
}

std::span<const tracking::Forecast> Pipeline::Impl::forecast_objects(std::int64_t timestamp_ns) {
  for (std::size_t slot = 0; slot < objects.size(); ++slot) {
    out.forecasts[slot] = objects[slot].alive() ? objects[slot].forecast(timestamp_ns, background.estimate().T_body_cam)
                                                : tracking::Forecast{};
  }
  return out.forecasts;
}

CameraState Pipeline::Impl::camera_at(std::size_t age) const {
  const SettledPose pose = background.history(age);
  CameraState camera{.T_world_cam = pose.T_body_cam,
                     .T_world_cam_before = std::nullopt,
                     .covariance = pose.covariance,
                     .scatter_px = background.scatter_px(),
                     .valid = pose.status == BodyStatus::kTracked};
  if (age + 1 < background.history_size()) {
    const SettledPose before = background.history(age + 1);
    camera.T_world_cam_before = before.status == BodyStatus::kTracked ? std::optional(before.T_body_cam) : std::nullopt;
  }
  return camera;
}

CameraResult Pipeline::Impl::camera_result(std::size_t age) const {
  const SettledPose pose = background.history(age);
  return {pose.status, pose.T_body_cam, rotation_position_covariance(pose.T_body_cam, pose.covariance), pose.inliers};
}

bool Pipeline::Impl::find_again(ObjectState& reborn, const Track& track, const FeatureFrame& frame, LabelView labels,
                                const CameraState& camera) {
  const std::optional<Eigen::Vector3d> position_m = reborn.sighted_position(frame, labels, camera);
  ObjectState* nearest = nullptr;
  double least = 1.0;
  for (ObjectState& lost : objects) {
    if (&lost == &reborn) {
      continue;
    }
    const std::optional<double> part = lost.placed() && position_m ? lost.may_have_gone_to(*position_m, track, camera)
                                                                   : lost.may_be_seen_as(track, camera);
    if (part && *part <= least) {
      nearest = &lost;
      least = *part;
    }
  }
  if (nearest == nullptr) {
    return false;
  }
  reborn.continue_from(*nearest, position_m);
  tracker.join(nearest->track().slot, reborn.track().slot);
  out.ring.move_slot(nearest->track().id, reborn.track().slot);
  nearest->hand_over();
  return true;
}

bool Pipeline::Impl::may_come_back(const Track& reborn, const CameraState& camera) const {
  return std::any_of(objects.begin(), objects.end(), [&](const ObjectState& lost) {
    return lost.track().slot != reborn.slot && lost.may_come_back_as(reborn, camera);
  });
}

void Pipeline::Impl::reconstruct(const FeatureFrame& frame, const TrackFrame& tracks) {
  background.extend(frame, kBackground);
  const CameraState camera = camera_at(0);
  for (std::size_t i = 0; i < tracker.tracks().size(); ++i) {
    Track track = tracker.tracks()[i];
    ObjectState& object = objects[track.slot];
    if (object.track().id != track.id) {
      object.begin(track);
    }
    if (!object.placed() && find_again(object, track, frame, tracks.left_labels, camera)) {
      track = tracker.track_in(track.slot);
      --i;  // It has taken the place of the earlier track, which came before.
    }
    if (!object.placed() && may_come_back(track, camera)) {
      tracker.withhold(track.slot);
      track = tracker.track_in(track.slot);
    }
    object.observe(track, frame, tracks.left_labels, camera, front_end);
    if (object.estranged()) {
      tracker.abandon(track.slot);
    }
  }
}

Status Pipeline::Impl::refine() {
  std::size_t count = 0;
  out.refinements[count++] = {&background, {}};
  for (ObjectState& object : objects) {
    if (object.alive() && object.reconstructing()) {
      out.refinements[count++] = {&object.body(), {}};
    }
  }
  if (Status refined = refiner.refine(out.refinements.first(count)); !refined) {
    return refined;
  }
  background.conclude(out.refinements[0].summary);
  const CameraState camera = camera_at(0);
  count = 1;
  for (ObjectState& object : objects) {
    if (object.alive()) {
      object.conclude(object.reconstructing() ? out.refinements[count++].summary : BundleSummary{}, camera);
    }
  }
  return {};
}

void Pipeline::Impl::count_tracks(const TrackFrame& tracks) {
  for (const Track& track : tracks.tracks) {
    if (track.id > newest_track_id) {
      newest_track_id = track.id;
      ++tracks_born;
    }
    const ObjectState& object = objects[track.slot];
    const bool was_confirmed = object.track().id == track.id && object.confirmed();
    tracks_confirmed += track.state == TrackState::kConfirmed && !was_confirmed ? 1U : 0U;
  }
  for (const Track& track : tracks.ended) {
    ++tracks_ended;
    objects[track.slot].end();
  }
}

void Pipeline::Impl::settle(const RectifiedPair& pair) {
  if (out.ring.full()) {
    out.ring.pop_oldest();
  }
  KeptFrame& kept = out.ring.push();
  ++unsettled;
  kept.frame_index = pair.frame_index;
  kept.timestamp_ns = pair.timestamp_ns;
  for (std::size_t slot = 0; slot < objects.size(); ++slot) {
    const ObjectState& object = objects[slot];
    if (object.alive() && object.status() != BodyStatus::kInitializing && !object.out_of_sight()) {
      KeptObject& entry = kept.objects[kept.object_count++];
      entry = KeptObject{.result = {}, .slot = static_cast<std::uint8_t>(slot), .confirmed = false};
      object.report(entry.result);
      entry.change = object.frame_change();
      if (object.correction()) {
        KeptPaths::correct(out.ring, unsettled, object.track().id, *object.correction());
      }
    }
  }
  revise_ring();
}

void Pipeline::Impl::revise_ring() {
  for (std::size_t age = 0; age < unsettled; ++age) {
    KeptFrame& kept = out.ring.frame(age);
    kept.camera = camera_result(age);
    const CameraState camera = camera_at(age);
    for (KeptObject& entry : kept.objects.first(kept.object_count)) {
      ObjectState& object = objects[entry.slot];
      if (object.alive() && object.track().id == entry.result.track_id) {
        object.revise(age, camera, entry.result);
        entry.confirmed = object.confirmed();
      } else {
        // Its track has ended: only the camera is still being refined.
        entry.result.T_world_obj = camera.T_world_cam * entry.result.T_obj_cam.inverse();
      }
    }
  }
  smooth_paths();
  for (std::size_t age = 0; age < unsettled; ++age) {
    KeptFrame& kept = out.ring.frame(age);
    for (KeptObject& entry : kept.objects.first(kept.object_count)) {
      const ObjectState& object = objects[entry.slot];
      if (object.alive() && object.track().id == entry.result.track_id) {
        object.describe_motion(age, entry.result);
      }
    }
  }
}

void Pipeline::Impl::smooth_paths() {
  for (std::size_t age = 0; age < unsettled; ++age) {
    KeptFrame& kept = out.ring.frame(age);
    for (const KeptObject& entry : kept.objects.first(kept.object_count)) {
      const std::uint32_t track_id = entry.result.track_id;
      if (!KeptPaths::ends_at(out.ring, track_id, age)) {
        continue;
      }
      ObjectState& object = objects[entry.slot];
      const bool at_rest = object.track().id == track_id && object.at_rest();
      if (const std::optional<PathEnd> end = paths.smooth(out.ring, unsettled, track_id, age, at_rest)) {
        object.learn_motion(end->T_world_obj, end->velocity);
      }
    }
  }
}

void Pipeline::Impl::publish_settled() {
  const KeptFrame& oldest = out.ring.frame(unsettled - 1);
  --unsettled;
  std::size_t count = 0;
  for (const KeptObject& entry : oldest.objects.first(oldest.object_count)) {
    if (entry.confirmed) {
      out.settled_objects[count++] = entry.result;
    }
  }
  result.has_settled = true;
  result.settled = {oldest.frame_index, oldest.timestamp_ns, oldest.camera, out.settled_objects.first(count)};
}

void Pipeline::Impl::publish_bodies(const TrackFrame* tracks) {
  const BodyEstimate& b = background.estimate();
  out.bodies[0] = {0, b.status, b.is_keyframe, b.points, b.frame_observations, b.retired};
  std::size_t count = 1;
  for (ObjectState& object : objects) {
    if (!object.in_use() || !object.confirmed()) {
      continue;
    }
    const BodyEstimate& e = object.body().estimate();
    out.bodies[count++] = {object.track().id, object.status(),      e.is_keyframe,
                           e.points,          e.frame_observations, e.retired};
    if (object.handed_over()) {
      object.release();
    }
  }
  result.bodies = out.bodies.first(count);
  if (tracks != nullptr) {
    for (const Track& track : tracks->ended) {
      objects[track.slot].release();
    }
  }
}

void Pipeline::Impl::publish(const RectifiedPair& pair, const TrackFrame& tracks) {
  const KeptFrame& newest = out.ring.frame(0);
  std::size_t count = 0;
  for (const KeptObject& entry : newest.objects.first(newest.object_count)) {
    if (entry.confirmed) {
      out.newest_objects[count++] = entry.result;
    }
  }
  result.newest = {newest.frame_index, newest.timestamp_ns, newest.camera, out.newest_objects.first(count)};
  result.has_settled = false;
  if (unsettled > as_size(config.background.window_frames)) {
    publish_settled();
  }
  publish_bodies(&tracks);
  result.tracks = tracker.tracks();
  result.pair = pair;
  result.left_labels = tracks.left_labels;
  result.right_labels = tracks.right_labels;
  result.counters = counters();
}

void Pipeline::Impl::report_rejected() {
  front_end.reject(background.rejected_slots());
  for (const ObjectState& object : objects) {
    if (object.in_use()) {
      front_end.reject(object.body().rejected_slots());
    }
  }
}

FrameCounters Pipeline::Impl::counters() const {
  const features::FeatureCounters& f = front_end.counters();
  const segmentation::SegmentationCounters& s = segmenter->counters();
  FrameCounters c;
  c.frames = frames;
  c.features_tracked = f.tracked;
  c.features_lost = f.lost();
  c.features_created = f.created;
  c.features_dropped = f.dropped;
  c.stereo_matched = f.stereo_matched;
  c.detections = s.detections;
  c.detections_dropped = s.detections_dropped + tracker.counters().detections_dropped;
  c.detection_frames_missing = s.frames_missing + s.frames_unreadable;
  c.mask_files_unreadable = s.files_unreadable;
  c.tracks_born = tracks_born;
  c.tracks_confirmed = tracks_confirmed;
  c.tracks_ended = tracks_ended;
  c.background_lost_frames = camera_lost_frames;
  const auto add_points = [&c](const sfm::BodyCounters& body) {
    c.points_created += body.points_created;
    c.points_culled += body.points_culled;
    c.points_dropped += body.points_dropped;
  };
  add_points(background.counters());
  for (const ObjectState& object : objects) {
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
  if (!self.drained) {
    self.drained = true;
    self.background.end();
    for (ObjectState& object : self.objects) {
      if (object.in_use()) {
        object.end();
      }
    }
    self.publish_bodies(nullptr);
    self.result.tracks = {};
    self.result.pair.left = {};
    self.result.pair.right = {};
    self.result.left_labels = {};
    self.result.right_labels = {};
  } else {
    self.result.bodies = {};
  }
  if (self.unsettled == 0) {
    return nullptr;
  }
  self.publish_settled();
  return &self.result;
}

}  // namespace kinetrace::pipeline
