// Drives one BodyReconstruction through frames as the pipeline does, with the online bundle adjuster behind it.
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm::test {

class BodyDriver {
 public:
  explicit BodyDriver(const BodyConfig& config, const StereoGeometry& geometry = kinetrace::test::street_rig())
      : BodyDriver(config, geometry,
                   {.max_frames = config.window_frames, .max_points = config.max_points, .max_iterations = 6}) {}
  BodyDriver(const BodyConfig& config, const StereoGeometry& geometry, const refinement::FixedBundleConfig& refinement)
      : arena_(BodyReconstruction::required_bytes(config) +
               refinement::FixedBundleAdjuster::required_bytes(refinement)),
        body_(take(BodyReconstruction::create(config, geometry, arena_))),
        adjuster_(take(refinement::FixedBundleAdjuster::create(refinement, arena_))) {}

  /// Processes a frame: begin() at `T_body_cam_first` or locate(), then extend, refine, conclude.
  const BodyEstimate& step(const FeatureFrame& frame, std::uint8_t label = 0, const Se3& T_body_cam_first = {},
                           const Eigen::Matrix3d* R_world_cam = nullptr) {
    if (!body_.active()) {
      body_.begin(T_body_cam_first);
    } else {
      body_.locate(frame, label);
    }
    return finish(frame, label, R_world_cam);
  }
  /// The steps after locate() or begin().
  const BodyEstimate& finish(const FeatureFrame& frame, std::uint8_t label = 0,
                             const Eigen::Matrix3d* R_world_cam = nullptr) {
    body_.extend(frame, label, R_world_cam);
    BundleWindow window = body_.window();
    return body_.conclude(refining_ ? take(adjuster_.refine(window)) : BundleSummary{});
  }

  void refine(bool on) { refining_ = on; }
  [[nodiscard]] BodyReconstruction& body() { return body_; }
  [[nodiscard]] const Arena& arena() const { return arena_; }

 private:
  template <typename T>
  static T take(Result<T> result) {
    if (!result) {
      throw std::runtime_error(result.error().message);
    }
    return std::move(*result);
  }

  Arena arena_;
  BodyReconstruction body_;
  refinement::FixedBundleAdjuster adjuster_;
  bool refining_ = true;
};

}  // namespace kinetrace::sfm::test
