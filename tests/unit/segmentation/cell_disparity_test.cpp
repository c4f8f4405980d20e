#include "kinetrace/segmentation/cell_disparity.hpp"

#include <gtest/gtest.h>

#include "moving_picture.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

StereoGeometry small_rig() {
  StereoGeometry g = test::street_rig();
  g.width_px = 320;
  g.height_px = 160;
  g.cx_px = 159.5;
  g.cy_px = 79.5;
  return g;
}

class CellDisparityTest : public ::testing::Test {
 protected:
  void compute(const test::Board& board, bool plain = false) {
    picture_.draw(board, plain);
    const RectifiedPair pair = picture_.pair(0, 0);
    disparity_.compute(pair.left, pair.right, 40.F);
  }
  StereoGeometry geometry_ = small_rig();
  static constexpr double kWall_px = 6.3;
  test::MovingPicture picture_{geometry_, kWall_px};
  Arena arena_{1U << 22U};
  CellDisparity disparity_{geometry_, arena_};
  const test::Board board_{120.0, 40.0, 80.0, 80.0, 17.6};
};

TEST_F(CellDisparityTest, FindsWallAndBoardToAFractionOfAPixel) {
  compute(board_);
  const ImageView<const float> cells = disparity_.disparity_px();
  int known = 0;
  int right = 0;
  for (int cy = 2; cy < cells.height - 2; ++cy) {
    for (int cx = 8; cx < cells.width - 2; ++cx) {
      const float u = cell_center(cx);
      const float v = cell_center(cy);
      const bool on_board = u > 128.F && u < 192.F && v > 48.F && v < 112.F;
      const bool clear_of_it = u < 92.F || u > 210.F || v < 30.F || v > 130.F;
      if (cells.row(cy)[cx] < 0.F || !(on_board || clear_of_it)) {
        continue;
      }
      ++known;
      right += std::abs(cells.row(cy)[cx] - (on_board ? 17.6F : 6.3F)) < 3.F * disparity_.sigma_px() ? 1 : 0;
    }
  }
  EXPECT_GT(known, 1500);
  EXPECT_GT(right, 0.98 * known);
}

TEST_F(CellDisparityTest, KnowsNothingAboutWhatTheRightCameraDoesNotSee) {
  // The board hides the wall to its left; the image's border hides a board at the left one.
  const test::Board at_border{0.0, 40.0, 80.0, 80.0, 35.2};
  int wrong = 0;
  int hidden = 0;
  for (const test::Board& board : {test::Board{160.0, 40.0, 80.0, 80.0, 35.2}, at_border}) {
    compute(board);
    const bool is_at_border = board.x0 < 1.0;
    const double x0 = is_at_border ? 0.0 : board.x0 - board.disparity_px + kWall_px;
    const double x1 = is_at_border ? board.disparity_px : board.x0;
    const ImageView<const float> cells = disparity_.disparity_px();
    for (int cy = 12; cy < 28; ++cy) {
      for (int cx = static_cast<int>(x0) / kCellPx + 2; cx < static_cast<int>(x1) / kCellPx - 1; ++cx) {
        ++hidden;
        wrong += cells.row(cy)[cx] >= 0.F ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_LT(wrong, hidden / 20);
}

TEST_F(CellDisparityTest, KnowsNothingAboutWhatIsPlain) {
  compute(board_, true);
  const ImageView<const float> cells = disparity_.disparity_px();
  for (int cy = 14; cy < 26; ++cy) {
    for (int cx = 34; cx < 46; ++cx) {
      EXPECT_LT(cells.row(cy)[cx], 0.F);
    }
  }
}

TEST_F(CellDisparityTest, ClearedItKnowsNothing) {
  compute(board_);
  disparity_.clear();
  EXPECT_LT(disparity_.disparity_px().row(20)[40], 0.F);
}

}  // namespace
}  // namespace kinetrace::segmentation
