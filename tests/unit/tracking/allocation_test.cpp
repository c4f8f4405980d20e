// The tracker never allocates after construction.
#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

TEST(TrackerAllocations, AreNone) {
  ASSERT_TRUE(allocation_counting_available());
  Arena arena(StereoTracker::required_bytes({}, kWidth, kHeight));
  StereoTracker tracker = StereoTracker::create({}, kWidth, kHeight, arena).value();
  std::uint64_t own = 0;
  for (int i = 0; i < 12; ++i) {
    Labels labels;
    const Shape near{.x = 100.0 + 20.0 * i, .y = 100.0};
    const Shape far{.x = 400.0 - 10.0 * i, .y = 100.0};
    labels.draw(far, 2);
    labels.draw(near, 1);
    const auto detections = measure_detections(std::as_const(labels).view(), std::array<std::uint8_t, 2>{1, 2},
                                               std::array<std::uint16_t, 2>{kVehicleClass, kVehicleClass});
    std::vector<Feature> features(30);
    for (std::size_t k = 0; k < features.size(); ++k) {
      features[k].left_px = {90.F + 20.F * static_cast<float>(i) + static_cast<float>(k), 90.F + static_cast<float>(k)};
      features[k].previous_left_px = features[k].left_px - Eigen::Vector2f(20.F, 0.F);
      features[k].u_right_px = features[k].left_px.x() - 10.F;
      features[k].age_frames = 1;
      features[k].body = 1;
    }
    DetectionFrame frame;
    frame.available = i % 4 != 3;
    if (frame.available) {
      frame.left_labels = frame.right_labels = std::as_const(labels).view();
      frame.left = frame.right = detections;
    }
    const std::uint64_t before = allocation_counts().own;
    const bool processed = tracker.process(i * kUsualInterval_ns, frame, features).has_value();
    own += allocation_counts().own - before;
    EXPECT_TRUE(processed);
  }
  EXPECT_GE(tracker.counters().born, 2U);
  EXPECT_EQ(own, 0U);
}

}  // namespace
}  // namespace kinetrace::tracking
