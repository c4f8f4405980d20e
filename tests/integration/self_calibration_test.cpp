// Self-calibration of rendered recordings whose rig is known, from the images and the baseline's length.
#include "self/self_calibration.hpp"

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rendering/stereo_simulator.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::self_calibration {
namespace {

using ::testing::HasSubstr;

/// Frames of a scene through distorted lenses, small and few, in memory.
class RenderedRecording {
 public:
  RenderedRecording(const std::string& scene, int frames, int width_px) {
    simulator::Scene made = simulator::make_scene(scene, 5).value();
    made.rig = simulator::resized(made.rig, width_px, std::nullopt);
    simulator::SimulatorSettings settings;
    settings.distortion = true;
    auto simulator = simulator::StereoSimulator::create(std::move(made), settings).value();
    baseline_m_ = simulator.rig().rectified.baseline_m;
    focal_px_ = simulator.rig().raw[0].K(0, 0);
    for (int i = 0; i < frames; ++i) {
      frames_.push_back(simulator.frame(i));
    }
  }

  [[nodiscard]] double focal_px() const { return focal_px_; }

  [[nodiscard]] Result<SelfCalibration> calibrated() const {
    SelfCalibrationOptions options;
    options.baseline_m = baseline_m_;
    options.windows = 3;
    options.pairs = 4;
    return self_calibrate({frames_.size(), [this](std::size_t place) { return frame(place); }}, options);
  }

 private:
  [[nodiscard]] Result<StereoFrame> frame(std::size_t place) const {
    StereoFrame frame;
    frame.left = frames_[place].pictures[0].view();
    frame.right = frames_[place].pictures[1].view();
    return frame;
  }

  std::vector<simulator::SimulatedFrame> frames_;
  double baseline_m_ = 0.0;
  double focal_px_ = 0.0;
};

TEST(SelfCalibration, FindsTheRigOfAShortFlight) {
  const RenderedRecording recording("drone", 30, 400);
  const auto result = recording.calibrated();
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_NEAR(result->rig.focal_px(0), recording.focal_px(), 0.01 * recording.focal_px());
  // The matches depend on how the processor rounds: by one this recording is off by 4.6 sigmas.
  EXPECT_LT(std::abs(result->rig.focal_px(0) / recording.focal_px() - 1.0), 6.0 * result->findings.focal_sigma);
  EXPECT_LT(result->findings.sigma_px, 0.1);
}

TEST(SelfCalibration, RefusesATurnInPlace) {
  const RenderedRecording recording("pure-rotation", 12, 400);
  const auto result = recording.calibrated();
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("turns but does not travel"));
}

TEST(SelfCalibration, RefusesACameraAtRest) {
  const RenderedRecording recording("static", 9, 400);
  const auto result = recording.calibrated();
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("at rest"));
}

TEST(SelfCalibration, RefusesTooFewFramesAndNoBaseline) {
  const FrameSource none{3, [](std::size_t) { return Result<StereoFrame>(StereoFrame{}); }};
  SelfCalibrationOptions options;
  EXPECT_EQ(self_calibrate(none, options).error().code, ErrorCode::kInvalidArgument);
  options.baseline_m = 0.1;
  EXPECT_THAT(self_calibrate(none, options).error().message, HasSubstr("3 frames"));
}

}  // namespace
}  // namespace kinetrace::self_calibration
