#include "kinetrace/sfm/point_map.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace kinetrace::sfm {
namespace {

Feature feature(std::uint32_t id, std::uint16_t slot) {
  Feature f;
  f.id = id;
  f.slot = slot;
  f.intensity = static_cast<std::uint8_t>(id);
  return f;
}

BundleObservation at(float u) {
  return {u, 2.F * u, u - 10.F, 1.F};
}

class PointMapTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kWindow = 4;
  Arena arena_{1 << 16};
  PointMap map_{arena_, 3, 10, kWindow};
};

TEST_F(PointMapTest, FindsWhatItCreatedAndNothingElse) {
  EXPECT_EQ(map_.find(feature(1, 0)), PointMap::kNone);
  const std::size_t row = map_.create(feature(1, 5));
  EXPECT_EQ(map_.find(feature(1, 5)), row);
  EXPECT_EQ(map_.find(feature(2, 5)), PointMap::kNone);  // Another feature in the same slot.
  EXPECT_EQ(map_.find(feature(1, 6)), PointMap::kNone);
  EXPECT_EQ(map_.state(row).intensity, 1);
  EXPECT_FALSE(map_.state(row).positioned);
  EXPECT_EQ(map_.state(row).seen, 0U);
}

TEST_F(PointMapTest, HoldsItsCapacityAndRefusesOneMore) {
  EXPECT_EQ(map_.capacity(), 3U);
  for (std::uint16_t i = 0; i < 3; ++i) {
    EXPECT_EQ(map_.create(feature(i + 1U, i)), i);
  }
  EXPECT_TRUE(map_.full());
  EXPECT_EQ(map_.create(feature(4, 3)), PointMap::kNone);
  EXPECT_EQ(map_.find(feature(4, 3)), PointMap::kNone);
  EXPECT_EQ(map_.size(), 3U);
}

TEST_F(PointMapTest, RemovalMovesTheLastRowAndFeaturesStillFindTheirs) {
  for (std::uint16_t i = 0; i < 3; ++i) {
    const std::size_t row = map_.create(feature(10U + i, i));
    map_.observe(row, 1, at(static_cast<float>(i)));
    map_.point(row).position_m.x() = i;
  }
  map_.remove(0);
  EXPECT_EQ(map_.size(), 2U);
  EXPECT_EQ(map_.find(feature(10, 0)), PointMap::kNone);
  const std::size_t last = map_.find(feature(12, 2));
  ASSERT_EQ(last, 0U);
  EXPECT_EQ(map_.point(last).position_m.x(), 2.0);
  EXPECT_EQ(map_.observations(last)[1].u_left_px, 2.F);
  EXPECT_EQ(map_.find(feature(11, 1)), 1U);
  map_.remove(1);
  map_.remove(0);
  EXPECT_EQ(map_.size(), 0U);
  EXPECT_EQ(map_.find(feature(12, 2)), PointMap::kNone);
}

TEST_F(PointMapTest, AReusedSlotLeadsToTheNewFeatureWhileTheOldPointLivesOn) {
  const std::size_t old_row = map_.create(feature(1, 7));
  const std::size_t new_row = map_.create(feature(2, 7));
  EXPECT_EQ(map_.find(feature(2, 7)), new_row);
  EXPECT_EQ(map_.find(feature(1, 7)), PointMap::kNone);
  map_.remove(old_row);  // Moves the new row to the old one's place.
  EXPECT_EQ(map_.find(feature(2, 7)), old_row);
  map_.remove(old_row);
  EXPECT_EQ(map_.find(feature(2, 7)), PointMap::kNone);
}

TEST_F(PointMapTest, MovingAnOldPointDoesNotTakeTheSlotFromTheNewFeature) {
  ASSERT_EQ(map_.create(feature(9, 0)), 0U);
  ASSERT_EQ(map_.create(feature(2, 7)), 1U);
  const std::size_t old_row = map_.create(feature(1, 7));  // Last row; then its slot passes on.
  map_.remove(1);
  EXPECT_EQ(map_.find(feature(1, 7)), 1U);
  const std::size_t new_row = map_.create(feature(3, 7));
  map_.remove(0);  // Moves the newest row.
  EXPECT_EQ(map_.find(feature(3, 7)), 0U);
  EXPECT_EQ(map_.find(feature(1, 7)), PointMap::kNone);
  EXPECT_EQ(old_row, 2U);
  EXPECT_EQ(new_row, 2U);
}

TEST_F(PointMapTest, DroppingAColumnMovesTheLaterOnesDown) {
  const std::size_t row = map_.create(feature(1, 0));
  map_.observe(row, 0, at(100.F));
  map_.observe(row, 1, at(101.F));
  map_.observe(row, 3, at(103.F));
  map_.remove_column(1);
  EXPECT_EQ(map_.state(row).seen, 0b0101U);
  EXPECT_EQ(map_.state(row).observed, 0b0101U);
  EXPECT_EQ(map_.observations(row)[0].u_left_px, 100.F);
  EXPECT_EQ(map_.observations(row)[2].u_left_px, 103.F);
  map_.remove_column(0);
  EXPECT_EQ(map_.state(row).seen, 0b0010U);
  map_.remove_column(3);  // The last, empty one.
  EXPECT_EQ(map_.state(row).seen, 0b0010U);
  map_.remove_column(1);
  EXPECT_EQ(map_.state(row).seen, 0U);
  EXPECT_EQ(map_.state(row).observations, 3);  // Observations over its life do not go with columns.
}

TEST(PointMap, DropsTheLastOfThirtyTwoColumns) {
  Arena arena(1 << 16);
  PointMap map(arena, 1, 1, 32);
  const std::size_t row = map.create(feature(1, 0));
  map.observe(row, 0, at(0.F));
  map.observe(row, 31, at(31.F));
  map.remove_column(0);
  EXPECT_EQ(map.state(row).seen, 1U << 30U);
  map.observe(row, 31, at(32.F));
  map.remove_column(31);
  EXPECT_EQ(map.state(row).seen, 1U << 30U);
}

TEST_F(PointMapTest, ForgetsSingleObservations) {
  const std::size_t row = map_.create(feature(1, 0));
  map_.observe(row, 0, at(100.F));
  map_.observe(row, 2, at(102.F));
  map_.forget(row, 0);
  EXPECT_EQ(map_.state(row).seen, 0b0100U);
  EXPECT_EQ(map_.state(row).observed, 0b0100U);
}

TEST_F(PointMapTest, FoldingWeighsBothObservations) {
  const std::size_t row = map_.create(feature(1, 0));
  map_.observe(row, 0, {100.F, 50.F, 90.F, 2.F});
  map_.merge(row, 0, {105.F, 55.F, 95.F, 1.F}, 100.F);
  const BundleObservation& o = map_.observations(row)[0];
  EXPECT_FLOAT_EQ(o.u_left_px, 101.F);  // Weights 4 and 1.
  EXPECT_FLOAT_EQ(o.v_px, 51.F);
  EXPECT_FLOAT_EQ(o.u_right_px, 91.F);
  EXPECT_FLOAT_EQ(o.inverse_sigma_px, std::sqrt(5.F));
  map_.merge(row, 0, o, 2.5F);
  EXPECT_FLOAT_EQ(map_.observations(row)[0].inverse_sigma_px, 2.5F);
  EXPECT_EQ(map_.state(row).observations, 1);
}

TEST_F(PointMapTest, FoldingTakesThePlaceOfAMissingObservationAndKeepsTheOnlyRightMatch) {
  const std::size_t row = map_.create(feature(1, 0));
  map_.merge(row, 2, {100.F, 50.F, kNoRight, 1.F}, 10.F);
  EXPECT_EQ(map_.state(row).seen, 0b0100U);
  EXPECT_EQ(map_.state(row).observed, 0U);  // Inherited, not seen by the frame itself.
  EXPECT_TRUE(std::isnan(map_.observations(row)[2].u_right_px));
  map_.merge(row, 2, {102.F, 50.F, 92.F, 1.F}, 10.F);
  EXPECT_FLOAT_EQ(map_.observations(row)[2].u_left_px, 101.F);
  EXPECT_FLOAT_EQ(map_.observations(row)[2].u_right_px, 92.F);
  map_.merge(row, 2, {101.F, 50.F, kNoRight, 1.F}, 10.F);
  EXPECT_FLOAT_EQ(map_.observations(row)[2].u_right_px, 92.F);
}

}  // namespace
}  // namespace kinetrace::sfm
