// Recognises a returning object by the appearance of its points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"

namespace kinetrace::pipeline {

/// Frames in the window from which the shape of a reconstruction is stable: a count of views, not a time.
inline constexpr std::size_t kMinBodyFrames = 6;

/// Prior of an object's pose, with standard deviations.
struct PosePrior {
  Se3 T_obj_cam;
  double rotation_sigma_rad = 0.0;  ///< About each axis.
  double position_sigma_m = 0.0;    ///< Along each axis.
};

/// Remembers the appearance of reconstructed points every few tenths of a second. After the object's return, appearance
/// matches with a common translation give its pose in its old frame. Truncation and occlusion shift the centre of the
/// visible part, but not these points.
class ObjectRecogniser {
 public:
  /// Memory: 56 kB.
  ObjectRecogniser(const StereoGeometry& geometry, Arena& arena);

  void clear() noexcept;
  void swap(ObjectRecogniser& other) noexcept;
  /// Enough points are remembered to recognise it.
  [[nodiscard]] bool has_enough_points() const noexcept;

  /// Call in every frame in which the object is tracked, `interval_ns` after the previous one; remembers points when
  /// due.
  void remember(const sfm::BodyReconstruction& body, const FeatureFrame& frame, std::uint8_t label,
                const features::FeatureFrontEnd& front_end, std::int64_t interval_ns);
  /// T_obj_cam of this frame, within three standard deviations of the prior (half of it vertically). Nothing if fewer
  /// than eight points agree, or only on an implausible rotation.
  [[nodiscard]] std::optional<Se3> recognise(const PosePrior& prior, sfm::BodyReconstruction& body, std::uint8_t label,
                                             const features::FeatureFrontEnd& front_end) const;

 private:
  /// Gate of appearance matches about a pose.
  struct MatchGate {
    double reach_m = 0.0;   ///< About the predicted position of a point; half of it vertically.
    double radius_m = 0.0;  ///< Of the consensus on the translation; in depth widened by stereo's noise.
    float min_similarity = 0.F;
  };
  struct PoseConsensus {
    Se3 T_obj_cam;
    std::size_t points = 0;
  };
  /// The pose on which most of the matches around `T_obj_cam` agree, combined with the prior.
  [[nodiscard]] std::optional<PoseConsensus> find_consensus(const Se3& T_obj_cam, const MatchGate& match_gate,
                                                            const PosePrior& prior, sfm::BodyReconstruction& body,
                                                            std::uint8_t label,
                                                            const features::FeatureFrontEnd& front_end) const;
  [[nodiscard]] std::size_t find_appearance_matches(const Se3& T_cam_obj, const MatchGate& match_gate,
                                                    std::uint8_t label, const features::FeatureFrontEnd& front_end,
                                                    std::span<features::RecognisedPoint> found) const;

  StereoGeometry geometry_;
  features::AppearanceMemory memory_;
  DwellTime since_memory_;
};

}  // namespace kinetrace::pipeline
