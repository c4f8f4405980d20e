#include "kinetrace/publishing/published_frame.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "sample_results.hpp"

namespace kinetrace::publishing {
namespace {

using test::SampleResult;

class PublishedFrameTest : public testing::Test {
 protected:
  PublishedFrame frame_of(const SampleResult& sample, int max_points, int max_objects = 4) {
    PublishConfig config;
    config.max_points = max_points;
    config.max_objects = max_objects;
    PublishedFrame frame(config, arena_);
    frame.assign(sample.result, 77);
    return frame;
  }
  static std::ptrdiff_t points_of(const PublishedFrame& frame, std::uint32_t track_id) {
    return std::count_if(frame.points.begin(), frame.points.end(),
                         [track_id](const PublishedPoint& p) { return p.track_id == track_id; });
  }
  Arena arena_{1 << 20};
};

TEST_F(PublishedFrameTest, TakesObjectsUpToTheCapacity) {
  for (const int objects : {0, 1, 4}) {
    EXPECT_EQ(frame_of(SampleResult({.objects = objects}), 10).objects.size(), static_cast<std::size_t>(objects));
  }
  EXPECT_EQ(frame_of(SampleResult({.objects = 5}), 10).objects.size(), 4U);
}

TEST_F(PublishedFrameTest, PutsPointsIntoTheWorld) {
  const PublishedFrame frame = frame_of(SampleResult({.objects = 1}, 9), 100);
  ASSERT_EQ(frame.points.size(), 14U);
  EXPECT_EQ(frame.points[3].position_m, SampleResult::point(0, 3)) << "the background's frame is the world";
  const Eigen::Vector3d expected = SampleResult::object(1, 9).T_world_obj * SampleResult::point(1, 2).cast<double>();
  EXPECT_TRUE(frame.points[12].position_m.cast<double>().isApprox(expected, 1e-6));
  EXPECT_EQ(frame.points[12].track_id, 1U);
  EXPECT_EQ(frame.points[12].intensity, 2);
  EXPECT_EQ(frame.handed_over_ns, 77);
}

TEST_F(PublishedFrameTest, ThinsAllBodiesAlike) {
  const SampleResult sample({.objects = 1, .background_points = 800, .points_per_object = 200});
  const PublishedFrame frame = frame_of(sample, 100);
  EXPECT_EQ(frame.points.size(), 100U);
  EXPECT_EQ(frame.points_available, 1000U);
  EXPECT_EQ(points_of(frame, 0), 80);
  EXPECT_EQ(points_of(frame, 1), 20);
}

TEST_F(PublishedFrameTest, KeepsAllThatJustFitAndThinsOneMore) {
  EXPECT_EQ(frame_of(SampleResult({.objects = 0, .background_points = 50}), 50).points.size(), 50U);
  const PublishedFrame frame = frame_of(SampleResult({.objects = 0, .background_points = 51}), 50);
  EXPECT_EQ(frame.points.size(), 50U);
  EXPECT_EQ(frame.points_available, 51U);
}

TEST_F(PublishedFrameTest, WithoutRoomForPointsThereAreNone) {
  const PublishedFrame frame = frame_of(SampleResult({}), 0);
  EXPECT_TRUE(frame.points.empty());
  EXPECT_EQ(frame.points_available, 18U);
}

TEST_F(PublishedFrameTest, ABodyWithoutAPlaceHasNoPoints) {
  SampleResult sample({.objects = 2});
  sample.result.newest.objects = std::span(sample.objects).first(1);
  EXPECT_EQ(points_of(frame_of(sample, 100), 2), 0);
}

}  // namespace
}  // namespace kinetrace::publishing
