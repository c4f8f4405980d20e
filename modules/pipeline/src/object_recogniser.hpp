// Recognises an object that has been out of view by what its points looked like.
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

/// A reconstruction with so many frames in its window has found its shape: views to adjust, not a time.
inline constexpr std::size_t kMinBodyFrames = 6;

/// Where an object may be, and how far off that is.
struct PoseGuess {
  Se3 T_obj_cam;
  double turn_sigma_rad = 0.0;  ///< About each axis.
  double place_sigma_m = 0.0;   ///< Along each axis.
};

/// Every few tenths of a second it takes note of how points of the reconstruction look. After the object's return,
/// points that look alike and have all moved alike tell its pose in its old frame: what is half outside the image or
/// half hidden has its middle elsewhere, its points have not.
class ObjectRecogniser {
 public:
  /// Memory: 56 kB.
  ObjectRecogniser(const StereoGeometry& geometry, Arena& arena);

  void clear() noexcept;
  void swap(ObjectRecogniser& other) noexcept;
  /// Enough has been noted to recognise it by.
  [[nodiscard]] bool knows_it() const noexcept;

  /// Call in every frame in which the object is well seen, `interval_ns` after the one before; takes note when it is
  /// time.
  void remember(const sfm::BodyReconstruction& body, const FeatureFrame& frame, std::uint8_t label,
                const features::FeatureFrontEnd& front_end, std::int64_t interval_ns);
  /// T_obj_cam of this frame, given where it is about: within three standard deviations (half of it vertically).
  /// Nothing if fewer than eight points agree, or only on a turn that it cannot have made.
  [[nodiscard]] std::optional<Se3> recognise(const PoseGuess& guess, sfm::BodyReconstruction& body, std::uint8_t label,
                                             const features::FeatureFrontEnd& front_end) const;

 private:
  /// Which matches count, seen from a pose.
  struct MatchGate {
    double reach_m = 0.0;   ///< From where the pose puts a point; half of it vertically.
    double radius_m = 0.0;  ///< Those that moved alike agree so well; in depth as far as stereo can tell.
    float min_similarity = 0.F;
  };
  struct Agreement {
    Se3 T_obj_cam;
    std::size_t points = 0;
  };
  /// The pose on which most of the matches around `T_obj_cam` agree, weighed against the guess.
  [[nodiscard]] std::optional<Agreement> agreement(const Se3& T_obj_cam, const MatchGate& match_gate,
                                                   const PoseGuess& guess, sfm::BodyReconstruction& body,
                                                   std::uint8_t label,
                                                   const features::FeatureFrontEnd& front_end) const;
  [[nodiscard]] std::size_t find_appearance_matches(const Se3& T_cam_obj, const MatchGate& match_gate,
                                                    std::uint8_t label, const features::FeatureFrontEnd& front_end,
                                                    std::span<features::RecognisedPoint> found) const;

  StereoGeometry geometry_;
  features::AppearanceMemory memory_;
  DwellTime since_note_;
};

}  // namespace kinetrace::pipeline
