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
  std::uint64_t detections = 0;            ///< Left detections seen.
  std::uint64_t detections_dropped = 0;    ///< Not born: no free slot, or smaller than min_area_px.
  std::uint64_t detections_duplicate = 0;  ///< Not born: lies on an object that is tracked already.
  std::uint64_t born = 0;
  std::uint64_t confirmed = 0;
  std::uint64_t ended = 0;
};

/// Gives instance masks an identity over time and carries it to the right image.
///
/// Prediction P: each track's last seen mask, moved by the similarity that its features follow (RANSAC); with fewer
/// than three features by their median displacement; with none to where its prediction says, or, without one or for
/// what passes too close by for one, by its last motion. Where features do not tell, it grows as its prediction comes
/// nearer. Features of a track that is hidden, or has not been detected in two frames, have passed to what hides it:
/// its mask goes where the prediction says. A mask that leaves the image, or of which a part is hidden, is kept whole
/// and comes back whole; what is not seen of it while something known to hide it is not detected is not taken from it.
/// Where predictions overlap, the one that has been seen to hide the other does so again (its detection lay where the
/// other's mask was expected), unless stereo sees it clearly farther away: masks are ragged; before that the one with
/// the larger disparity; without disparity a track counts as behind all others, and among those the lower edge of the
/// box decides.
///
/// Association: one assignment per frame (Kuhn-Munkres). Its weights are log-likelihood ratios: that the detection
/// shows the track, against its being new and the track being missed (src/association_cost.hpp). They add up the edges
/// of the detection given the predicted mask, where hidden and truncated edges tell less; the share of the track's
/// features that lie on it; its disparity; its class; the probability of detection given how much of the track should
/// be visible; and that a detection on another track's mask may be a fragment of that. Pairs below zero are left out,
/// which is the optimum of the assignment with births and misses (Bar-Shalom, Li 1995). Features and predictions may
/// have gone astray: with a small prior the track is also looked for where it last was.
///
/// Life: a detection that no track claims is born tentative, confirmed when matched in `confirm_frames` frames,
/// propagated by its prediction for `max_missed_s`, and ended then. A confirmed track with a prediction waits for
/// another `max_unseen_s`, so that a thing keeps its name when the camera looks away or something passes in front
/// of it: while it is outside the image or hidden by others it may be assigned a detection by its prediction mask;
/// where it should have been in view, only merge_tracks() brings it back. Without a prediction a track ends as soon as
/// its mask leaves the image or shrinks below `min_area_px`. Frames without detections (`available == false`) propagate
/// every track and count as missed for confirmed ones only towards `max_missed_s`. Births at capacity: the largest
/// detections first; a track that is tentative and unmatched, or else has been propagated for more than half of
/// `max_missed_s`, ends to make room for the next frame; else the smallest track, if the detection is more than
/// twice its size; the rest is dropped and counted.
///
/// Pixels: matched tracks show their detection, others, for `max_missed_s`, what of their prediction nobody else
/// claims. Detected pixels that belong to no track are kIgnoreLabel.
///
/// Memory: 3 label images and max_objects + 1 bit images. Nothing is allocated after creation.
class StereoTracker {
 public:
  [[nodiscard]] static std::size_t required_bytes(const TrackerConfig& config, int width_px, int height_px);
  /// Errors: kInvalidConfig (names the key), kInvalidArgument (image size), kCapacity (arena too small).
  [[nodiscard]] static Result<StereoTracker> create(const TrackerConfig& config, int width_px, int height_px,
                                                    Arena& arena);

  /// One frame, later than the one before it. `features` are tracked into this frame, their `body` is the label in the
  /// previous frame's result. `predictions`: by slot, of this frame; may be shorter. The result lives until the next
  /// call of this or merge_tracks(). Errors: kInvalidArgument (label images of another size).
  [[nodiscard]] Result<TrackFrame> process(std::int64_t timestamp_ns, const DetectionFrame& detections,
                                           std::span<const Feature> features,
                                           std::span<const ObjectPrediction> object_predictions = {});

  /// From the next frame on, only so many tracks are alive at once. Of those beyond, what has not been detected for
  /// longest ends first, then the smallest; births follow the rule for capacity.
  void limit(int most_tracks) noexcept { most_tracks_ = most_tracks; }

  /// The track in this slot turned out to have passed to another object: it ends with the next frame, and what it lies
  /// on may be born again under its own id. Slots without a live track are ignored.
  void terminate(std::uint8_t slot) noexcept;

  /// The track in slot `redetected` is the thing that the one in slot `earlier`, born before it, has lost: it goes on
  /// under that track's id, class votes and state, and takes its place in tracks(); that track, and all that was shown
  /// of it in this frame, is gone without an end being reported, and its slot is free.
  void merge_tracks(std::uint8_t earlier, std::uint8_t redetected) noexcept;

  /// The track in this slot, detected again in this frame, shows something else there: that goes on in its slot as a
  /// new track, and the track itself waits in a free one, dormant and without a mask, as it had been before this frame
  /// (`before`). Returns that slot; nothing, and nothing has changed, where none is free.
  [[nodiscard]] std::optional<std::uint8_t> split_track(std::uint8_t slot, const Track& before) noexcept;

  /// The track in this slot may turn out to be an earlier one: in this frame it is reported as tentative.
  void defer_confirmation(std::uint8_t slot) noexcept;

  /// As of the last frame, and what has been joined and deferred since: alive, in ascending id, each id once.
  [[nodiscard]] std::span<const Track> tracks() const noexcept { return published_.span(); }
  /// The one in this slot, which there is.
  [[nodiscard]] const Track& track_in(std::uint8_t slot) const noexcept {
    return *std::find_if(published_.begin(), published_.end(), [slot](const Track& t) { return t.slot == slot; });
  }
  [[nodiscard]] const TrackerCounters& counters() const noexcept { return counters_; }

  /// Ends everything without saying so; ids go on, counters stay.
  void reset() noexcept;

 private:
  StereoTracker() = default;
  static void carve(const TrackerConfig& config, int width_px, int height_px, Arena& arena, StereoTracker& tracker);
  [[nodiscard]] Status check(const DetectionFrame& detections) const;

  void begin_frame(std::int64_t timestamp_ns) noexcept;
  void set_predictions(std::span<const ObjectPrediction> object_predictions) noexcept;
  void predict(std::span<const Feature> features);
  /// Puts the mask to where the prediction expects it, which is its motion then; false without one, and for what passes
  /// by too near for one.
  [[nodiscard]] static bool place_by_prediction(TrackInstance& instance) noexcept;
  /// Outside the image or behind other tracks: no detection can be expected.
  [[nodiscard]] bool is_out_of_view(const TrackInstance& instance) const noexcept;
  /// Not after it has been missing where it should have been in view, or while it is nearly outside the image: what is
  /// detected there is born anew.
  [[nodiscard]] bool is_assignable(const TrackInstance& instance) const noexcept;
  /// What hides an object moves otherwise, and its features are taken for the object's.
  [[nodiscard]] bool may_follow_occluder(const TrackInstance& instance) const noexcept;
  /// So many features, on what was last seen of a mask, show by how much it grows; of a whole one any do.
  [[nodiscard]] static bool shows_size(const TrackInstance& instance, std::size_t features) noexcept;
  /// By which factor it grows into this frame, where its features do not tell: as its prediction comes nearer, or as it
  /// last grew; a part of it seen behind something else says nothing.
  [[nodiscard]] static double expected_growth(const TrackInstance& instance) noexcept;
  /// The same motion of the centre, with this growth and without a turn.
  [[nodiscard]] static Similarity with_growth(const Similarity& motion, double growth,
                                              const Eigen::Vector2d& center_px) noexcept;
  /// How far the mask last moved, size and turn unchanged: what does not come from this frame must not add up.
  [[nodiscard]] static Similarity shift_of(TrackInstance& instance) noexcept;
  [[nodiscard]] Similarity predict_motion(TrackInstance& instance, std::span<const Feature> features);
  void draw_predictions(LabelView detections) noexcept;
  /// Who hides whom, from what was detected where whole masks were expected.
  void estimate_occlusion_order(const DetectionFrame& detections) noexcept;
  void count_votes(LabelView detections, std::span<const Feature> features) noexcept;
  void associate(const DetectionFrame& detections, std::span<const Feature> features) noexcept;
  /// Log-likelihood ratio of the detection being this track, against its being new and the track being missed.
  /// `disparity_px`: of the detection, the median over `samples` features.
  [[nodiscard]] double evidence(const TrackInstance& instance, const Detection& detection, double disparity_px,
                                std::size_t samples) const noexcept;
  /// Of where the detection lies: on the predicted mask, hidden parts included, or where the track was a moment ago.
  [[nodiscard]] double place_evidence(const TrackInstance& instance, const Detection& detection) const noexcept;
  /// Of the detection, on the predicted mask of another track of its class.
  [[nodiscard]] double part_on_others(const TrackInstance& instance, const Detection& detection) const noexcept;
  [[nodiscard]] static bool is_behind_camera(const TrackInstance& instance) noexcept;
  /// Of the detection, on the whole predicted mask.
  [[nodiscard]] static double part_on(const TrackInstance& instance, const Detection& detection) noexcept;
  void apply_assignment(const Assignment& match, std::size_t columns) noexcept;
  void accept_match(TrackInstance& instance, const Detection& detection) noexcept;
  void learn_motion(TrackInstance& instance, const Detection& detection) const noexcept;
  void accept_miss(TrackInstance& instance, bool was_looked_for) noexcept;
  /// One step of its life (life_cycle.hpp).
  void advance(TrackInstance& instance, const LifeEvidence& evidence) noexcept;
  void end(TrackInstance& instance) noexcept;
  void initiate_tracks(const DetectionFrame& detections, std::span<const Feature> features);
  [[nodiscard]] bool is_duplicate(const DetectionFrame& detections, std::size_t index,
                                  std::span<const Feature> features);
  [[nodiscard]] bool start_track(const DetectionFrame& detections, std::size_t index) noexcept;
  /// An instance in a slot of its own without a track; null if there is none, or as many tracks as there may be.
  [[nodiscard]] TrackInstance* free_instance() noexcept;
  /// A new track begins in this instance with a detection of this class.
  void be_born(TrackInstance& instance, std::uint16_t class_id) noexcept;
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
  /// Something that has been seen to hide it is expected before it, and has not been detected in this frame: what is
  /// not seen of it says nothing about its shape.
  [[nodiscard]] bool misses_what_hides(const TrackInstance& instance) const noexcept;
  void publish() noexcept;
  void sort_published() noexcept;

  /// The stereo features whose pixel carries `label`, as samples_.first(n).
  [[nodiscard]] std::span<const DisparitySample> gather_samples(LabelView labels, std::uint8_t label,
                                                                std::span<const Feature> features) noexcept;
  void sort_far_to_near() noexcept;
  /// Has been seen to hide it, and stereo does not see it clearly farther away.
  [[nodiscard]] static bool hides(const TrackInstance& front, const TrackInstance& behind) noexcept;
  /// Hides it, or else, by disparity, likely to.
  [[nodiscard]] static bool nearer(const TrackInstance& a, const TrackInstance& b) noexcept;
  [[nodiscard]] static bool is_nearer(const TrackInstance& a, const TrackInstance& b) noexcept;

  /// The settings that are times.
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
  int most_tracks_ = std::numeric_limits<int>::max();
  std::uint32_t next_id_ = 1;
  std::uint32_t frame_ = 0;
  bool started_ = false;
  std::int64_t timestamp_ns_ = 0;                 ///< Of this frame, or the last one.
  std::int64_t interval_ns_ = kUsualInterval_ns;  ///< Since the frame before.

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
