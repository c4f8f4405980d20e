// Stereo multiple object tracking on pixel level (Bullinger et al. 2018, sec. 2.1).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/track_frame.hpp"
#include "kinetrace/tracking/assignment.hpp"
#include "kinetrace/tracking/config.hpp"
#include "kinetrace/tracking/track_instance.hpp"

namespace kinetrace::tracking {

/// Running totals since creation.
struct TrackerCounters {
  std::uint64_t detections = 0;            ///< Left detections.
  std::uint64_t detections_dropped = 0;    ///< No track: no free slot, or smaller than min_area_px.
  std::uint64_t detections_duplicate = 0;  ///< No track: on an object that is tracked already.
  std::uint64_t born = 0;
  std::uint64_t confirmed = 0;
  std::uint64_t ended = 0;
};

/// Gives instance masks identities over time, in the left and the right image.
///
/// Prediction P: each track's last observed mask, moved by the similarity of its features (RANSAC). Fallbacks: with
/// fewer than three features, their median displacement; without features, the predicted position; without a
/// prediction, or where the object passes too close for one, its last motion. Where features do not determine the
/// scale, the mask grows as the predicted depth decreases. The features of a track that is occluded, or undetected for
/// longer than kMaxFeatureGap_ns, have moved on to the occluder: its mask follows the prediction. A truncated or
/// partly occluded mask is kept whole, so that it reappears whole; it is not cut down while a known occluder is not
/// detected. Occlusion order of overlapping predictions: a track observed to occlude the other (its detection lay where
/// the other's mask was expected) stays in front, unless stereo measures it clearly farther away, since masks are
/// ragged. Otherwise the larger disparity is in front; tracks without disparity are behind all others and are ordered
/// by the lower edge of the box. An object undetected in the last frame is not expected behind the box of a nearer one
/// detected in it, whose mask may lack parts.
///
/// Association: one assignment per frame (Kuhn-Munkres). Its weights are log-likelihood ratios: the detection belongs
/// to the track, against a new object and a missed track (src/association_cost.hpp). Their terms are the edges of the
/// detection given the predicted mask or the predicted extent of the object's box, whichever makes them likelier, and
/// beyond the image border the box alone, with occluded and truncated edges censored; the share of the track's features
/// on the detection; its disparity; its class; the probability of detection given the expected visible part; and the
/// probability that a detection on another track's mask is a fragment of that track. Edges and disparity give way to
/// the space of the object's box if the detection's features lie there, and its centre in the box's image: it may be
/// any part. Pairs below zero are left out, which is the optimum of the assignment with births and misses (Bar-Shalom,
/// Li 1995). Features and prediction may both be wrong: the last observed position is a further hypothesis, with a
/// small prior.
///
/// Life: an unassigned detection initiates a tentative track, unless it lies mostly on the predicted mask of a track of
/// its class, or is of unknown class and its features lie in the space of a detected object of known class. The track
/// is confirmed when matched in `confirm_frames` frames. Undetected, it is propagated by its prediction for
/// `max_missed_s`, and ended then. A confirmed track with a prediction waits for another `max_unseen_s`, so that an
/// object keeps its identity while the camera turns away or an occluder passes: while it is outside the image or
/// occluded, its predicted mask may be assigned a detection; once it has been missing in plain sight for
/// `max_missed_s`, only merge_tracks() revives it. Without a prediction a track ends as soon as its mask leaves the
/// image or shrinks below `min_area_px`. Frames without detections (`available == false`) propagate every track; they
/// count towards `max_missed_s`, not towards `max_tentative_missed_s`. Initiation at capacity: the largest detections
/// first; those without a free slot are dropped and counted. To make room in the next frame, a track ends: one that is
/// tentative and unmatched, or else has been propagated for more than half of `max_missed_s`, or else the smallest, if
/// the detection is more than twice its size.
///
/// Pixels: a matched track owns its detection; an unmatched one, for `max_missed_s`, the pixels of its prediction that
/// no other track owns. Detected pixels of no track are kIgnoreLabel.
///
/// Memory: 3 label images and max_objects + 1 bit images. Nothing is allocated after creation.
class StereoTracker {
 public:
  [[nodiscard]] static std::size_t required_bytes(const TrackerConfig& config, int width_px, int height_px);
  /// Errors: kInvalidConfig (names the key), kInvalidArgument (image size), kCapacity (arena too small).
  [[nodiscard]] static Result<StereoTracker> create(const TrackerConfig& config, int width_px, int height_px,
                                                    Arena& arena);

  /// One frame, later than the previous one. `features` are tracked into this frame, their `body` is the label in the
  /// previous frame's result. `object_predictions`: of this frame, by slot; may be shorter. The result is valid until
  /// the next call of this or merge_tracks(). Errors: kInvalidArgument (label images of another size).
  [[nodiscard]] Result<TrackFrame> process(std::int64_t timestamp_ns, const DetectionFrame& detections,
                                           std::span<const Feature> features,
                                           std::span<const ObjectPrediction> object_predictions = {});

  /// Limits the number of live tracks from the next frame on. Of those beyond, the longest undetected ends first, then
  /// the smallest; initiation follows the rule for capacity.
  void limit(int max_tracks) noexcept { max_tracks_ = max_tracks; }

  /// The track in this slot has switched to another object: it ends with the next frame, and that object may initiate a
  /// track with its own id. Slots without a live track are ignored.
  void terminate(std::uint8_t slot) noexcept;

  /// Re-identification: the track in slot `redetected` shows the object of the older track in slot `earlier`. It takes
  /// over that track's id, class votes, state and place in tracks(). The older track and its pixels in this frame are
  /// removed without reporting an end, and its slot is free.
  void merge_tracks(std::uint8_t earlier, std::uint8_t redetected) noexcept;

  /// The detection assigned to the track in this slot belongs to another object, which keeps the slot as a new track.
  /// The old track moves to a free slot, dormant, without a mask and as it was `before` this frame. Returns that slot;
  /// nothing, and without any change, if none is free.
  [[nodiscard]] std::optional<std::uint8_t> split_track(std::uint8_t slot, const Track& before) noexcept;

  /// Live tracks as of the last frame, with the merges and splits since, in ascending id, each id once.
  [[nodiscard]] std::span<const Track> tracks() const noexcept { return published_.span(); }
  /// The track in this slot, which must have one.
  [[nodiscard]] const Track& track_in(std::uint8_t slot) const noexcept {
    return *std::find_if(published_.begin(), published_.end(), [slot](const Track& t) { return t.slot == slot; });
  }
  [[nodiscard]] const TrackerCounters& counters() const noexcept { return counters_; }

  /// Drops all tracks without reporting their end; ids continue, counters stay.
  void reset() noexcept;

 private:
  StereoTracker() = default;
  static void carve(const TrackerConfig& config, int width_px, int height_px, Arena& arena, StereoTracker& tracker);
  [[nodiscard]] Status check(const DetectionFrame& detections) const;

  void begin_frame(std::int64_t timestamp_ns) noexcept;
  void set_predictions(std::span<const ObjectPrediction> object_predictions) noexcept;
  void predict(std::span<const Feature> features);
  /// Moves the mask to its predicted position and sets the motion accordingly; false without a prediction, or where the
  /// object passes too close for one.
  [[nodiscard]] static bool place_mask_by_prediction(TrackInstance& instance) noexcept;
  /// Outside the image or occluded by other tracks: no detection is expected.
  [[nodiscard]] bool is_out_of_view(const TrackInstance& instance) const noexcept;
  /// False for a dormant track: re-identification alone assigns it a detection.
  [[nodiscard]] static bool is_assignable(const TrackInstance& instance) noexcept;
  /// The features of an occluded track may lie on the occluder, which moves differently.
  [[nodiscard]] static bool may_follow_occluder(const TrackInstance& instance) noexcept;
  /// Whether this many features on the visible part determine the change of scale; on an unoccluded mask any do.
  [[nodiscard]] static bool is_scale_observable(const TrackInstance& instance, std::size_t features) noexcept;
  /// Change of scale into this frame where features do not determine it: by the predicted depths, or else the last one,
  /// but not that of a partly occluded mask.
  [[nodiscard]] static double expected_growth(const TrackInstance& instance) noexcept;
  /// The same motion of the centre, with this change of scale and without rotation.
  [[nodiscard]] static Similarity with_growth(const Similarity& motion, double growth,
                                              const Eigen::Vector2d& center_px) noexcept;
  /// The last translation of the mask, without scale and rotation: those of earlier frames must not accumulate.
  [[nodiscard]] static Similarity shift_of(TrackInstance& instance) noexcept;
  [[nodiscard]] Similarity predict_motion(TrackInstance& instance, std::span<const Feature> features);
  void draw_predictions(LabelView detections) noexcept;
  /// Erases predicted pixels of objects undetected in the last frame behind the boxes of those detected in it.
  void erase_hidden() noexcept;
  void erase_hidden(const TrackInstance& behind, const PredictedVolume& front) noexcept;
  /// Occlusion order, from the detections where whole masks were expected.
  void estimate_occlusion_order(const DetectionFrame& detections) noexcept;
  void count_votes(LabelView detections, std::span<const Feature> features) noexcept;
  void associate(const DetectionFrame& detections, std::span<const Feature> features) noexcept;
  /// Log-likelihood ratio of the detection belonging to this track, against a new object and a missed track.
  /// `disparity_px`: of the detection, median over `samples`.
  [[nodiscard]] double evidence(const TrackInstance& instance, const Detection& detection, double disparity_px,
                                std::span<const DisparitySample> samples) const noexcept;
  /// Evidence of where the detection is: as predicted, or any part of the object, in the space that it occupies.
  [[nodiscard]] double place_evidence(const TrackInstance& instance, const Detection& detection, double disparity_px,
                                      std::span<const DisparitySample> samples) const noexcept;
  /// Evidence of a detection with these samples being any part of the object, in the space that it occupies and in its
  /// extent in the image; minus infinity without a box or samples.
  [[nodiscard]] static double part_evidence(const TrackInstance& instance, const Detection& detection,
                                            std::span<const DisparitySample> samples) noexcept;
  /// Evidence of the detection's position: in the predicted extent of the object's box, on the predicted mask, occluded
  /// parts included, or at the last observed position.
  [[nodiscard]] double position_evidence(const TrackInstance& instance, const Detection& detection) const noexcept;
  /// Part of the detection on the predicted mask of another track of its class, the largest.
  [[nodiscard]] double overlap_fraction_with_others(const TrackInstance& instance,
                                                    const Detection& detection) const noexcept;
  /// Expected of its mask: neither occluded by other tracks nor outside the image.
  [[nodiscard]] static double visible_fraction(const TrackInstance& instance) noexcept;
  [[nodiscard]] static bool is_behind_camera(const TrackInstance& instance) noexcept;
  /// Part of the detection on the whole predicted mask.
  [[nodiscard]] static double overlap_fraction(const TrackInstance& instance, const Detection& detection) noexcept;
  void apply_assignment(const Assignment& match, std::size_t columns) noexcept;
  void accept_match(TrackInstance& instance, const Detection& detection) noexcept;
  void correct_motion(TrackInstance& instance, const Detection& detection) const noexcept;
  void accept_miss(TrackInstance& instance, bool was_looked_for) noexcept;
  /// One transition of its life (life_cycle.hpp).
  void advance(TrackInstance& instance, const LifeEvidence& evidence) noexcept;
  void end(TrackInstance& instance) noexcept;
  void initiate_tracks(const DetectionFrame& detections, std::span<const Feature> features);
  /// Mostly on the predicted mask of a track of its class, or a moving part of its object.
  [[nodiscard]] bool is_duplicate(const Detection& detection, std::span<const DisparitySample> samples) const noexcept;
  /// A region of unknown class in the space of an object of known class that has a detection of its own.
  [[nodiscard]] static bool is_moving_part(const TrackInstance& instance, const Detection& detection,
                                           std::span<const DisparitySample> samples) noexcept;
  [[nodiscard]] bool start_track(const DetectionFrame& detections, std::size_t index) noexcept;
  /// A free slot; null if there is none, or the number of tracks is at its limit.
  [[nodiscard]] TrackInstance* free_instance() noexcept;
  /// Initiates a new track in this slot, by a detection of this class.
  void initiate(TrackInstance& instance, std::uint16_t class_id) noexcept;
  void evict_track(int for_area_px) noexcept;
  [[nodiscard]] int alive() const noexcept;
  /// Ends tracks beyond the limit.
  void prune_to_capacity() noexcept;
  void draw_left(const DetectionFrame& detections) noexcept;
  void remember_mask(TrackInstance& instance, const Detection& detection) noexcept;
  void attach_right(const DetectionFrame& detections, std::span<const Feature> features);
  void update_disparity(TrackInstance& instance, std::span<const Feature> features);
  void draw_right_prediction(TrackInstance& instance) noexcept;
  void associate_right(const DetectionFrame& detections) noexcept;
  /// A known occluder is predicted in front of it and was not detected in this frame: unseen parts are no evidence of
  /// its shape.
  [[nodiscard]] bool has_undetected_occluder(const TrackInstance& instance) const noexcept;
  void publish() noexcept;
  void sort_published() noexcept;

  /// The stereo features whose pixel carries `label`, as samples_.first(n).
  [[nodiscard]] std::span<const DisparitySample> gather_samples(LabelView labels, std::uint8_t label,
                                                                std::span<const Feature> features) noexcept;
  void sort_far_to_near() noexcept;
  /// `front` was observed to occlude `behind`, and stereo does not measure it clearly farther away.
  [[nodiscard]] static bool occludes(const TrackInstance& front, const TrackInstance& behind) noexcept;
  /// `a` is in front of `b`, by observed occlusion or else by disparity.
  [[nodiscard]] static bool is_in_front(const TrackInstance& a, const TrackInstance& b) noexcept;
  [[nodiscard]] static bool is_nearer_by_disparity(const TrackInstance& a, const TrackInstance& b) noexcept;

  /// Settings that are times.
  struct Limits {
    std::int64_t missed_ns = 0;
    std::int64_t unseen_ns = 0;
    std::int64_t tentative_missed_ns = 0;
  };

  TrackerConfig config_;
  Limits limits_;
  TrackerCounters counters_;
  int width_px_ = 0;
  int height_px_ = 0;
  int max_tracks_ = std::numeric_limits<int>::max();
  std::uint32_t next_id_ = 1;
  std::uint32_t frame_ = 0;
  bool started_ = false;
  std::int64_t timestamp_ns_ = 0;                 ///< Of this frame, or between frames the last one.
  std::int64_t interval_ns_ = kUsualInterval_ns;  ///< Since the previous frame.

  MutableLabelView left_;
  MutableLabelView right_;
  MutableLabelView prediction_;
  FixedVector<TrackInstance> slots_;
  ReferenceMask spare_mask_;
  FixedVector<std::uint8_t> far_to_near_;  ///< Slots of live tracks.
  FixedVector<std::int16_t> owner_;        ///< Slot of each left detection, -1 = none.
  FixedVector<Track> published_;
  FixedVector<Track> ended_;
  std::span<PointPair> pairs_;
  std::span<DisparitySample> samples_;
  std::span<float> scratch_;
  AffinityMatrix affinity_;
};

}  // namespace kinetrace::tracking
