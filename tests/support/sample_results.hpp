// Results with a distinct value in every field, without a pipeline.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kinetrace/core/frame_result.hpp"

namespace kinetrace::test {

struct SampleContent {
  int objects = 2;
  int background_points = 10;
  int points_per_object = 4;
};

/// The result of one frame at 30 Hz: the camera drives ahead at 3 m/s and turns a little; objects have ids 1, 2, ...
/// and a distinct position, speed and class each. The finalised frame is the newest one.
class SampleResult {
 public:
  explicit SampleResult(const SampleContent& content, std::int64_t frame = 0);
  SampleResult(const SampleResult&) = delete;
  SampleResult& operator=(const SampleResult&) = delete;

  static constexpr double kSpeed_mps = 3.0;
  static constexpr double kTurn_radps = 0.3;
  static constexpr std::int64_t kPeriod_ns = 33'333'333;
  [[nodiscard]] static std::int64_t timestamp_ns(std::int64_t frame) {
    return 1'700'000'000'000'000'000 + frame * kPeriod_ns;
  }
  [[nodiscard]] static Se3 T_world_cam(std::int64_t frame);
  [[nodiscard]] static ObjectResult object(std::uint32_t track_id, std::int64_t frame);
  /// In the body's frame.
  [[nodiscard]] static Eigen::Vector3f point(std::uint32_t track_id, std::size_t i);
  [[nodiscard]] static StereoGeometry geometry();

  FrameResult result;
  std::vector<ObjectResult> objects;
  std::vector<BodyGeometry> bodies;

 private:
  std::vector<std::vector<BodyPoint>> points_;
};

}  // namespace kinetrace::test
