#include "native/trajectory_pieces.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

struct Sent {
  std::uint32_t track_id;
  bool finished;
  std::uint32_t first_pose;
  std::size_t poses;
};

class TrajectoryPiecesTest : public testing::Test {
 protected:
  std::vector<Sent> add(std::uint32_t track_id, bool ends = false) {
    TrajectoryEvent event;
    event.track_id = track_id;
    event.ends = ends;
    event.frame_index = frame_++;
    std::vector<Sent> sent;
    pieces_.add(event, [&](const TrajectoryPart& part) {
      sent.push_back({part.track_id, part.finished, part.first_pose, part.poses.size()});
    });
    return sent;
  }
  static PublishConfig config() {
    PublishConfig config;
    config.max_objects = 2;  // Room for four.
    return config;
  }
  std::int64_t frame_ = 0;
  Arena arena_{1 << 20};
  TrajectoryPieces pieces_{config(), arena_};
};

TEST_F(TrajectoryPiecesTest, APieceIsSentWhenItIsFull) {
  for (std::size_t i = 0; i + 1 < TrajectoryPieces::kMaxPoses; ++i) {
    EXPECT_TRUE(add(7).empty());
  }
  const std::vector<Sent> full = add(7);
  ASSERT_EQ(full.size(), 1U);
  EXPECT_EQ(full[0].poses, 64U);
  EXPECT_FALSE(full[0].finished);
  EXPECT_TRUE(add(7).empty());
  const std::vector<Sent> last = add(7, true);
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(last[0].first_pose, 64U);
  EXPECT_EQ(last[0].poses, 1U);
  EXPECT_TRUE(last[0].finished);
}

TEST_F(TrajectoryPiecesTest, AnEndRightAfterAFullPieceIsPublishedToo) {
  for (std::size_t i = 0; i < TrajectoryPieces::kMaxPoses; ++i) {
    static_cast<void>(add(7));
  }
  const std::vector<Sent> last = add(7, true);
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(last[0].poses, 0U);
  EXPECT_TRUE(last[0].finished);
}

TEST_F(TrajectoryPiecesTest, TheEndOfAnUnpublishedTrackIsNotPublished) {
  EXPECT_TRUE(add(9, true).empty());
}

TEST_F(TrajectoryPiecesTest, OneMoreThanThereIsRoomForMakesTheOldestGoOut) {
  for (std::uint32_t id = 1; id <= 4; ++id) {
    EXPECT_TRUE(add(id).empty());
  }
  EXPECT_TRUE(add(1).empty()) << "1 has news again, so 2 is the oldest now";
  const std::vector<Sent> evicted = add(5);
  ASSERT_EQ(evicted.size(), 1U);
  EXPECT_EQ(evicted[0].track_id, 2U);
  EXPECT_EQ(evicted[0].poses, 1U);
  EXPECT_FALSE(evicted[0].finished);
  const std::vector<Sent> first = add(1, true);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].poses, 2U);
  EXPECT_TRUE(add(6).empty()) << "the place of 1 is free";
}

TEST(TrajectoryPieces, PiecesAreSmallerWhereMessagesMustBe) {
  PublishConfig config;
  config.piece_bytes = PublishConfig::kMinPieceBytes;
  config.max_objects = 1;
  Arena arena(1 << 20);
  TrajectoryPieces pieces(config, arena);
  std::size_t poses = 0;
  for (int i = 0; i < 64 && poses == 0; ++i) {
    TrajectoryEvent event;
    event.track_id = 1;
    pieces.add(event, [&](const TrajectoryPart& part) { poses = part.poses.size(); });
  }
  EXPECT_GT(poses, 40U);
  EXPECT_LE(poses * sizeof(kinetrace_TrajectoryPose), 4096U);
}

}  // namespace
}  // namespace kinetrace::publishing
