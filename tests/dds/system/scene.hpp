// A constant scene, except for the clock and the camera's drive. ros_expectations.cpp has the expected messages, as
// numbers written by hand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/published_frame.hpp"

namespace kinetrace::test {

/// Frame i is of the time kBegin_ns + i * kStep_ns. The camera is at (1, 2, 3 + 0.01 i), turned about the world's y
/// axis by the angle whose half has sine 0.6 and cosine 0.8; its covariance is diag(1, 2, 3, 4, 5, 6), and 0.5 between
/// rotation about x and position along y. Objects have ids from kFirstId, the first one moves at 2 m/s along z; behind
/// them comes one more, which is lost.
class Scene {
 public:
  static constexpr std::int64_t kBegin_ns = 1'700'000'000'000'000'000;
  static constexpr std::int64_t kStep_ns = 10'000'000;
  static constexpr std::uint32_t kFirstId = 17;

  struct Options {
    std::size_t objects = 1;
    bool has_new_ids = false;  ///< In every frame: the objects of the previous one are gone.
  };

  explicit Scene(const Options& options);

  /// Valid until the next call.
  [[nodiscard]] const FrameResult& next();
  [[nodiscard]] publishing::PublishedHealth health() const;
  /// Ids published so far.
  [[nodiscard]] std::uint32_t ids() const noexcept { return next_id_ - kFirstId; }
  [[nodiscard]] static StereoGeometry geometry();

 private:
  void place_objects();

  Options options_;
  std::int64_t frame_ = 0;
  std::uint32_t next_id_ = kFirstId;
  std::vector<ObjectResult> objects_;
  std::vector<ObjectResult> finalised_objects_;
  std::array<BodyPoint, 2> background_points_;
  BodyPoint object_point_;
  std::vector<BodyGeometry> bodies_;
  FrameResult result_;
};

}  // namespace kinetrace::test
