// Whether two keyframes show the same place, and the relative pose between them.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "../pair_reader.hpp"
#include "../path_graph.hpp"
#include "keyframes.hpp"

namespace kinetrace::batch {

/// Appearance proposes: the earlier keyframes with the most similar thumbnails (Milford & Wyeth 2012), then binary
/// descriptors of the run's own points (ORB; Rublee et al. 2011). Stereo geometry decides: a pose from three points by
/// random samples, then patches of the earlier left picture aligned in both later ones and adjusted over the two
/// frames. Memory: 20 KiB per keyframe examined. Deterministic.
class PlaceMatcher {
 public:
  /// `T_world_cam`: the path so far; loops must be consistent with it.
  PlaceMatcher(const recording::Run& run, std::span<const Se3> T_world_cam, PairReader read,
               const AdjustmentOptions& options)
      : run_(run), T_world_cam_(T_world_cam), read_(std::move(read)), options_(options) {}

  /// The first of the candidates, ordered by similarity of their thumbnails, that shows the same place. Errors: those
  /// of reading a pair.
  Result<std::optional<Loop>> match(std::span<const Keyframe> keyframes, std::size_t now,
                                    std::span<const std::size_t> candidates);

 private:
  struct View {
    cv::Mat left, right;
  };
  struct Place {
    cv::Mat thumbnail;                   ///< Zero mean, unit norm.
    std::vector<std::size_t> described;  ///< Indices of the keyframe's points.
    cv::Mat descriptors;                 ///< One a row.
  };

  Result<View> view_of(const Keyframe& keyframe) const;
  Result<const Place*> place_of(const Keyframe& keyframe);
  [[nodiscard]] std::optional<Se3> coarse_pose(const Keyframe& then, const Place& place, const View& view_now) const;
  Result<std::optional<Loop>> adjusted(const Keyframe& then, const Keyframe& now, const View& view_now,
                                       const Se3& T_now_then) const;
  [[nodiscard]] bool fits_path(const Loop& loop, const Keyframe& then, const Keyframe& now) const;

  const recording::Run& run_;
  std::span<const Se3> T_world_cam_;
  PairReader read_;
  const AdjustmentOptions& options_;
  std::map<std::size_t, Place> places_;  ///< By row.
};

}  // namespace kinetrace::batch
