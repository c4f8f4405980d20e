// Correspondences of one frame: left->next and left->right, each with an identity for the life of its track.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

/// One tracked image point.
struct Feature {
  std::uint32_t id = 0;    ///< Unique in a run, never reused; 0 means none.
  std::uint16_t slot = 0;  ///< Index in [0, capacity), stable while the feature lives, reused afterwards.
  std::uint8_t body = 0;   ///< Label of the body whose mask holds the feature: 0 background, track slot + 1 otherwise,
                           ///< kIgnoreLabel none.
  std::uint8_t intensity = 0;                  ///< Gray value at the feature, to colour points.
  std::uint32_t age_frames = 0;                ///< Frames tracked; 0 in the frame of its detection.
  Eigen::Vector2f left_px{0.F, 0.F};           ///< Position in the left image.
  Eigen::Vector2f previous_left_px{0.F, 0.F};  ///< Position in the previous left image; equals left_px when age is 0.
  float v_px =
      0.F;  ///< Row used for geometry: mean of the rows of the pair (paper), or left_px.y without a right match.
  float u_right_px = kNoRight;           ///< Column in the right image, NaN where unmatched.
  float previous_v_px = 0.F;             ///< v_px of the previous frame.
  float previous_u_right_px = kNoRight;  ///< u_right_px of the previous frame, NaN where unmatched.

  [[nodiscard]] bool has_right() const noexcept { return u_right_px == u_right_px; }
  [[nodiscard]] bool had_right() const noexcept { return previous_u_right_px == previous_u_right_px; }
  [[nodiscard]] float disparity_px() const noexcept { return left_px.x() - u_right_px; }
};

/// All features alive in a frame. The span lives in the feature module until its next call.
struct FeatureFrame {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::span<Feature> features;
};

/// Where a feature of the previous frame is expected now, by its slot. Made from the body's motion.
struct FeaturePrediction {
  Eigen::Vector2f left_px{0.F, 0.F};
  float disparity_px = -1.F;  ///< Expected disparity, negative when unknown.
  bool known = false;         ///< False: start from the previous position and search coarse to fine.
};

}  // namespace kinetrace
