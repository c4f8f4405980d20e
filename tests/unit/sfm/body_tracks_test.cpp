// Single tracks and points.
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "body_driver.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;
using kinetrace::test::SyntheticWorld;
using test::BodyDriver;

TEST(BodyTracks, ATrackThatKeepsDisagreeingIsHandedBack) {
  SyntheticWorld world({.background_features = 300,
                        .min_track_frames = 40,
                        .max_track_frames = 60,
                        .wrong_track_ratio = 0.2,
                        .seed = 3});
  BodyConfig config;
  config.reject_after_frames = 5;
  BodyDriver driver{config};
  std::set<std::uint32_t> rejected;
  std::set<std::uint32_t> long_wrong;
  int good = 0;
  for (int i = 0; i < 20; ++i) {
    const FeatureFrame frame = world.observe(driven(0.5 * i));
    driver.step(frame);
    std::map<std::uint16_t, std::uint32_t> id_of_slot;
    for (const Feature& f : frame.features) {
      id_of_slot[f.slot] = f.id;
      if (world.wrong(f.id) && f.age_frames > 10) {
        long_wrong.insert(f.id);
      }
    }
    for (const std::uint16_t slot : driver.body().rejected_slots()) {
      ASSERT_TRUE(id_of_slot.contains(slot));
      good += !world.wrong(id_of_slot[slot]) && rejected.insert(id_of_slot[slot]).second ? 1 : 0;
      rejected.insert(id_of_slot[slot]);
      EXPECT_GE(i, config.reject_after_frames);
    }
  }
  ASSERT_GT(long_wrong.size(), 20U);
  const auto missed = std::count_if(long_wrong.begin(), long_wrong.end(),
                                    [&rejected](std::uint32_t id) { return !rejected.contains(id); });
  EXPECT_LE(missed, static_cast<std::ptrdiff_t>(long_wrong.size() / 5));
  EXPECT_LE(good, 3);
}

TEST(BodyTracks, RejectionIsReportedFrameAfterFrameWithoutEnd) {
  // The count of disagreements must not overflow and make the feature an inlier again.
  SyntheticWorld world({.background_features = 100,
                        .min_track_frames = 400,
                        .max_track_frames = 400,
                        .wrong_track_ratio = 0.1,
                        .seed = 5});
  BodyDriver driver{BodyConfig{}};
  std::map<std::uint32_t, int> reported;
  for (int i = 0; i < 300; ++i) {
    const FeatureFrame frame = world.observe({});
    driver.step(frame);
    for (const std::uint16_t slot : driver.body().rejected_slots()) {
      for (const Feature& f : frame.features) {
        reported[f.id] += f.slot == slot ? 1 : 0;
      }
    }
    for (const Feature& f : frame.features) {
      if (reported.contains(f.id) && reported[f.id] > 0) {
        EXPECT_TRUE(std::ranges::count(driver.body().rejected_slots(), f.slot) == 1) << "feature " << f.id;
      }
    }
  }
}

TEST(BodyTracks, WrongTracksLeaveNoPoints) {
  SyntheticWorld world({.wrong_track_ratio = 0.2, .wrong_right_ratio = 0.05, .seed = 4});
  BodyDriver driver{BodyConfig{}};
  int wrong = 0;
  int all = 0;
  for (int i = 0; i < 40; ++i) {
    const BodyEstimate& e = driver.step(world.observe(driven(0.8 * i)));
    for (const BodyPoint& p : e.retired) {
      if (p.observations >= 3) {
        ++all;
        wrong += world.wrong(p.id) ? 1 : 0;
      }
    }
  }
  ASSERT_GT(all, 500);
  EXPECT_LT(wrong, all / 50);
}

TEST(BodyTracks, PointsAreExactWithoutNoiseAndRetireOnce) {
  SyntheticWorld world({.sigma_px = 0.0, .seed = 6});
  BodyDriver driver{BodyConfig{}};
  std::set<std::uint32_t> retired;
  double worst_m = 0.0;
  for (int i = 0; i < 40; ++i) {
    const BodyEstimate& e = driver.step(world.observe(driven(0.8 * i, 0.005)));
    for (const BodyPoint& p : e.retired) {
      EXPECT_TRUE(retired.insert(p.id).second) << "point " << p.id << " retired twice";
      EXPECT_GE(p.observations, 2);
      EXPECT_EQ(p.intensity, p.id % 256U);
      worst_m = std::max(worst_m, (p.position_m.cast<double>() - world.point_of(p.id)).norm());
    }
    std::set<std::uint32_t> live;
    for (const BodyPoint& p : e.points) {
      EXPECT_TRUE(live.insert(p.id).second);
      EXPECT_FALSE(retired.contains(p.id));
    }
    for (const PointObservation& o : e.frame_observations) {
      EXPECT_TRUE(live.contains(o.point_id));
    }
  }
  EXPECT_GT(retired.size(), 1000U);
  EXPECT_LT(worst_m, 0.02);
}

TEST(BodyTracks, EveryPointOfAReusedSlotIsItsOwn) {
  // Short tracks and a small pool: every slot is reused all the time.
  SyntheticWorld world({.capacity = 120,
                        .background_features = 120,
                        .sigma_px = 0.0,
                        .min_track_frames = 2,
                        .max_track_frames = 4,
                        .seed = 7});
  BodyConfig config;
  config.max_features = 120;
  BodyDriver driver{config};
  for (int i = 0; i < 40; ++i) {
    const BodyEstimate& e = driver.step(world.observe(driven(0.4 * i)));
    EXPECT_EQ(e.status, BodyStatus::kTracked);
    for (const BodyPoint& p : e.points) {
      EXPECT_LT((p.position_m.cast<double>() - world.point_of(p.id)).norm(), 0.02) << "frame " << i;
    }
  }
}

TEST(BodyTracks, PointsOfOneCameraComeFromTemporalViews) {
  SyntheticWorld world({.background_features = 400, .min_track_frames = 25, .seed = 8});
  BodyDriver driver{BodyConfig{}};
  FeatureFrame frame;
  for (int i = 0; i < 12; ++i) {
    frame = world.observe(driven(0.8 * i));
    for (Feature& f : frame.features) {
      if (f.slot % 4 == 0) {
        f.u_right_px = kNoRight;
      }
    }
    driver.step(frame);
  }
  std::set<std::uint32_t> seen_by_one_view;
  for (const Feature& f : frame.features) {
    if (f.slot % 4 == 0) {
      seen_by_one_view.insert(f.id);
    }
  }
  std::vector<double> relative_error;
  for (const BodyPoint& p : driver.body().estimate().points) {
    if (seen_by_one_view.contains(p.id) && p.observations >= 6) {
      const Eigen::Vector3d& truth = world.point_of(p.id);
      relative_error.push_back((p.position_m.cast<double>() - truth).norm() / (truth - driven(8.8).translation).norm());
    }
  }
  ASSERT_GT(relative_error.size(), 20U);
  std::ranges::sort(relative_error);
  EXPECT_LT(relative_error[relative_error.size() / 2], 0.01);
}

TEST(BodyTracks, OneFrameOfFlawsForgivesAFeature) {
  // A single bad match is no reason to give up a good point.
  SyntheticWorld world({.background_features = 200, .min_track_frames = 40, .max_track_frames = 60, .seed = 9});
  BodyDriver driver{BodyConfig{}};
  std::set<std::uint32_t> spoiled;
  FeatureFrame frame;
  for (int i = 0; i < 8; ++i) {
    frame = world.observe(driven(0.5 * i));
    for (Feature& f : frame.features) {
      if (i == 5 && f.slot < 40) {
        f.left_px.x() += 30.F;
        spoiled.insert(f.id);
      }
    }
    driver.step(frame);
    EXPECT_TRUE(driver.body().rejected_slots().empty());
    for (const Feature& f : frame.features) {
      EXPECT_FALSE(i == 5 && spoiled.contains(f.id) && driver.body().agreed(f));
    }
  }
  std::set<std::uint32_t> live;
  for (const PointObservation& o : driver.body().estimate().frame_observations) {
    live.insert(o.point_id);
  }
  int still_tracked = 0;
  int survived = 0;
  for (const Feature& f : frame.features) {
    still_tracked += spoiled.contains(f.id) ? 1 : 0;
    survived += spoiled.contains(f.id) && live.contains(f.id) ? 1 : 0;
  }
  EXPECT_GT(still_tracked, 20);
  EXPECT_GE(survived, still_tracked - 2);
}

}  // namespace
}  // namespace kinetrace::sfm
