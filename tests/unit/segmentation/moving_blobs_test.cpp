// A person-sized board on level ground before a wall, seen by a camera that stands still.
#include "kinetrace/segmentation/moving_blobs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/segmentation/motion_memory.hpp"
#include "moving_picture.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr std::int64_t kInterval_ns = 100'000'000;
constexpr double kWall_px = 6.3;
constexpr double kCameraHeight_m = 1.6;
/// 19.5 m away: a pixel is 27 mm wide.
const test::Board kPerson{60.0, 57.0, 26.0, 60.0, 20.0};

StereoGeometry small_rig() {
  StereoGeometry g = test::street_rig();
  g.width_px = 320;
  g.height_px = 200;
  g.cx_px = 159.5;
  g.cy_px = 60.0;
  return g;
}

class MovingBlobsTest : public ::testing::Test {
 protected:
  std::span<const MovingBlob> step(const test::Board& board) {
    draw(board);
    const GrayView left{left_.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
    const GrayView right{right_.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
    history_.push(left, {}, frame_ * kInterval_ns);
    disparity_.compute(left, right, 70.F);
    ground_.fit(disparity_.disparity_px(), static_cast<std::uint32_t>(++frame_));
    const DenseView dense{disparity_, ground_, history_};
    return blobs_.find(dense, TemporalTest(geometry_, history_), {}, 0.0);
  }
  static std::ptrdiff_t moving(std::span<const MovingBlob> blobs) {
    return std::count_if(blobs.begin(), blobs.end(), [](const MovingBlob& b) { return b.moving; });
  }
  /// Part of the board's cells, a cell from its border, of which `wanted` holds.
  template <typename Wanted>
  [[nodiscard]] double share(const test::Board& board, Wanted wanted) const {
    int yes = 0;
    int all = 0;
    for (int cy = static_cast<int>(board.y0) / kCellPx + 2; cy < static_cast<int>(board.y0 + 40.0) / kCellPx; ++cy) {
      for (int cx = static_cast<int>(board.x0) / kCellPx + 2;
           cx < static_cast<int>(board.x0 + board.width) / kCellPx - 1; ++cx) {
        yes += wanted(blobs_.blob_of_cell().row(cy)[cx]) ? 1 : 0;
        ++all;
      }
    }
    return static_cast<double>(yes) / all;
  }

  StereoGeometry geometry_ = small_rig();
  Arena arena_{16U << 20U};
  FrameHistory history_{geometry_.width_px, geometry_.height_px, arena_};
  CellDisparity disparity_{geometry_, arena_};
  GroundPlane ground_{geometry_, arena_};
  MovingBlobs blobs_{MotionConfig{}, geometry_, arena_};

 private:
  void draw(const test::Board& board) {
    for (int y = 0; y < geometry_.height_px; ++y) {
      const double ground_px = (y - geometry_.cy_px) * geometry_.baseline_m / kCameraHeight_m;
      const double behind_px = std::max(kWall_px, ground_px);
      for (int x = 0; x < geometry_.width_px; ++x) {
        const std::size_t i = static_cast<std::size_t>(y * geometry_.width_px + x);
        left_[i] = grey(x, y, 0.0, board, behind_px);
        right_[i] = grey(x, y, 1.0, board, behind_px);
      }
    }
  }
  static std::uint8_t grey(int x, int y, double right, const test::Board& board, double behind_px) {
    const double u = x + right * board.disparity_px - board.x0;
    const double v = y - board.y0;
    const bool on_board = u >= 0.0 && v >= 0.0 && u < board.width && v < board.height;
    const double value = on_board ? test::texture(u, v, 2) : test::texture(x + right * behind_px, y, 1);
    return static_cast<std::uint8_t>(std::clamp(20.0 + 0.8 * value, 0.0, 255.0));
  }

  std::vector<std::uint8_t> left_ = std::vector<std::uint8_t>(static_cast<std::size_t>(320 * 200));
  std::vector<std::uint8_t> right_ = left_;
  std::int64_t frame_ = 0;
};

TEST_F(MovingBlobsTest, APersonWhoWalksAcrossIsOneBlobWithItsVelocity) {
  test::Board person = kPerson;
  std::span<const MovingBlob> blobs;
  for (int i = 0; i < 8; ++i) {
    person.x0 += 3.0;
    blobs = step(person);
  }
  ASSERT_TRUE(ground_.known());
  ASSERT_EQ(moving(blobs), 1);
  const auto b = std::find_if(blobs.begin(), blobs.end(), [](const MovingBlob& blob) { return blob.moving; });
  EXPECT_NEAR(b->velocity_mps.x(), 3.0 / 0.1 * geometry_.baseline_m / person.disparity_px, 0.1);
  EXPECT_NEAR(b->velocity_mps.y(), 0.0, 0.1);
  EXPECT_NEAR(b->velocity_mps.z(), 0.0, 0.5);
  const auto index = static_cast<std::int16_t>(b - blobs.begin());
  EXPECT_GT(share(person, [&](std::int16_t owner) { return owner == index; }), 0.7);
}

TEST_F(MovingBlobsTest, NothingMovesInAPictureThatStaysTheSame) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(step(kPerson).empty()) << i;
  }
  EXPECT_GT(share(kPerson, [](std::int16_t owner) { return owner == MovingBlobs::kStandsStill; }), 0.7);
}

TEST_F(MovingBlobsTest, ABlobIsConfirmedAfterMoreThanTwoFrames) {
  test::Board person = kPerson;
  for (int i = 0; i < 3; ++i) {
    person.x0 += 3.0;
    EXPECT_EQ(moving(step(person)), 0) << i;
  }
}

TEST_F(MovingBlobsTest, WhatIsTooSmallIsNoObject) {
  test::Board ball{60.0, 80.0, 10.0, 10.0, 20.0};
  for (int i = 0; i < 10; ++i) {
    ball.x0 += 3.0;
    EXPECT_EQ(moving(step(ball)), 0) << i;
  }
}

TEST_F(MovingBlobsTest, WhatSwaysMovesThoughNoVelocityFitsForLong) {
  test::Board person = kPerson;
  std::span<const MovingBlob> blobs;
  for (int i = 0; i < 12; ++i) {
    person.x0 += i % 2 == 0 ? 2.0 : -2.0;
    blobs = step(person);
  }
  EXPECT_EQ(moving(blobs), 1);
}

TEST_F(MovingBlobsTest, NothingIsKnownAfterAReset) {
  test::Board person = kPerson;
  for (int i = 0; i < 6; ++i) {
    person.x0 += 3.0;
    step(person);
  }
  blobs_.reset();
  person.x0 += 3.0;
  for (const MovingBlob& blob : step(person)) {
    EXPECT_EQ(blob.frames, 1);
    EXPECT_FALSE(blob.moving);
  }
}

TEST(MotionMemoryWithBlobs, AMovingBlobBeginsARegionThatLastsWhileItsCellsChange) {
  Arena arena(1U << 20U);
  MotionMemory memory(MotionConfig{}, 10, arena);
  std::vector<MovingBlob> blobs(1);
  blobs[0].information = Eigen::Matrix3f::Identity();
  blobs[0].velocity_mps = {1.F, 0.F, 0.F};
  std::uint32_t id = 0;
  const auto frame = [&](bool seen, bool moving) {
    blobs[0].moving = moving;
    memory.begin(kInterval_ns, {}, {});
    memory.update({}, {}, {}, {}, {});
    memory.update_blobs(std::span(blobs).first(seen ? 1 : 0), std::span(&id, 1), {});
    memory.conclude({}, {});
    return memory.regions().size();
  };
  EXPECT_EQ(frame(true, false), 0U) << "changed cells alone are no region";
  ASSERT_EQ(frame(true, true), 1U);
  EXPECT_TRUE(memory.regions()[0].reported);
  EXPECT_EQ(memory.region_of_blob()[0], 0);
  EXPECT_EQ(memory.regions()[0].velocity_mps, blobs[0].velocity_mps);
  id = memory.regions()[0].id;
  EXPECT_EQ(frame(true, false), 1U);
  EXPECT_TRUE(memory.regions()[0].reported);
  EXPECT_EQ(frame(false, false), 0U);
}

}  // namespace
}  // namespace kinetrace::segmentation
