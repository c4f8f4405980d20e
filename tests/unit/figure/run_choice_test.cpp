#include "figure/figure_choice.hpp"
#include "run_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::figure {
namespace {

using ::testing::HasSubstr;

TEST(FigureRun, FindsRowsByFrameAndTrack) {
  const FigureRun run = open(small_street());
  EXPECT_EQ(run.first_frame(), 0);
  EXPECT_EQ(run.last_frame(), 9);
  EXPECT_EQ(run.camera_at(4)->frame, 4);
  EXPECT_EQ(run.camera_at(10), nullptr);
  EXPECT_EQ(run.camera_at(-1), nullptr);
  EXPECT_EQ(run.objects_at(3).size(), 3U);
  EXPECT_TRUE(run.objects_at(10).empty());
  ASSERT_EQ(run.tracks().size(), 3U);
  EXPECT_EQ(run.track(2)->rows.size(), 10U);
  EXPECT_EQ(run.track(4), nullptr);
  EXPECT_DOUBLE_EQ(run.seconds(run.camera_at(9)->timestamp_ns), 0.9);
}

TEST(FigureRun, RowsSurviveAMove) {
  FigureRun run = open(small_street());
  const recording::ObjectRow* row = run.track(1)->rows.front();
  const FigureRun moved = std::move(run);
  EXPECT_EQ(moved.track(1)->rows.front(), row);
  EXPECT_EQ(&moved.objects_at(0).front(), row);
}

TEST(FigureRun, ATrackMovesIfItDoesInThreeFramesAndAFifthOfThem) {
  const auto with_moving_frames = [](int moving, int frames) {
    recording::Run run = straight_drive(frames);
    for (int i = 0; i < frames; ++i) {
      run.objects.push_back(object_row(i, 1, {0, 0, 10}));
      run.objects.back().moving = i < moving;
    }
    return open(std::move(run)).track(1)->moving;
  };
  EXPECT_FALSE(with_moving_frames(2, 3));
  EXPECT_TRUE(with_moving_frames(3, 15));
  EXPECT_FALSE(with_moving_frames(3, 16));
}

TEST(FigureRun, ATrackHasTheClassThatItHadLastInAllFrames) {
  recording::Run run = straight_drive(2);
  for (int i = 0; i < 2; ++i) {
    run.objects.push_back(object_row(i, 1, {0, 0, 10}));
    run.objects.back().class_id = static_cast<std::uint16_t>(i);  // 1: a car
  }
  EXPECT_EQ(open(std::move(run)).objects_at(0).front().class_id, 1);
}

TEST(FigureRun, WithoutFramesIsAnError) {
  const Result<FigureRun> run = FigureRun::from(straight_drive(0));
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(run.error().message, HasSubstr("no frame"));
}

TEST(FigureRun, AFolderThatIsNoRunIsAnError) {
  const test::TempFolder scratch;
  EXPECT_EQ(FigureRun::open(scratch.path()).error().code, ErrorCode::kNotFound);
}

TEST(FigureRun, NamesTracks) {
  EXPECT_EQ(track_name(1, 7), "car 7");
  EXPECT_EQ(track_name(2, 8), "pedestrian 8");
  EXPECT_EQ(track_name(0, 9), "object 9");
  EXPECT_EQ(track_name(3, 9), "object 9");
  EXPECT_EQ(with_unit(7.649, 1, "m/s"), "7.6 m/s");
}

TEST(ChooseFrame, PrefersWhatMovesIsTallAndWhole) {
  recording::Run run = straight_drive(5);
  const auto add = [&](int frame, bool moving, int height, PixelBox box) {
    recording::ObjectRow row = object_row(frame, 1, {0, 0, 10});
    row.moving = moving;
    row.pixel_height = height;
    row.mask_px = box;
    run.objects.push_back(row);
  };
  add(0, true, 50, {100, 50, 150, 100});
  add(1, true, 60, {100, 50, 150, 110});
  add(2, true, 100, {0, 10, 50, 110});  // Cut off by the left edge.
  add(3, false, 150, {100, 5, 150, 155});
  EXPECT_EQ(choose_frame(open(run), kImageWidth, kImageHeight), 1);
  // A picture that is just as wide cuts the object off.
  EXPECT_EQ(choose_frame(open(run), 150, kImageHeight), 2);
}

TEST(ChooseFrame, IgnoresWhatIsNotTracked) {
  recording::Run run = small_street();
  for (recording::ObjectRow& row : run.objects) {
    row.status = row.frame == 7 ? BodyStatus::kTracked : BodyStatus::kStereoOnly;
  }
  EXPECT_EQ(choose_frame(open(std::move(run)), kImageWidth, kImageHeight), 7);
}

TEST(ChooseFrame, WithoutObjectsIsTheMiddle) {
  EXPECT_EQ(choose_frame(open(straight_drive(11)), kImageWidth, kImageHeight), 5);
  EXPECT_EQ(choose_frame(open(straight_drive(1)), kImageWidth, kImageHeight), 0);
}

TEST(ChooseFrame, TakesTheFirstOfEquals) {
  EXPECT_EQ(choose_frame(open(small_street()), kImageWidth, kImageHeight), 0);
}

TEST(ChooseFrameOf, IsWhereTheTrackIsTallest) {
  recording::Run run = straight_drive(4);
  for (int i = 0; i < 4; ++i) {
    run.objects.push_back(object_row(i, 1, {0, 0, 10}));
    run.objects.back().pixel_height = 10 * (i + 1);
  }
  run.objects[3].status = BodyStatus::kStereoOnly;
  EXPECT_EQ(choose_frame_of(*open(run).track(1)), 2);
  for (recording::ObjectRow& row : run.objects) {
    row.status = BodyStatus::kLost;
  }
  EXPECT_EQ(choose_frame_of(*open(run).track(1)), 0);
}

TEST(ChooseObject, IsTheBestOfTheFrameElseOfTheRun) {
  EXPECT_EQ(choose_object(open(small_street()), 3, kImageWidth, kImageHeight), 1U);
  recording::Run run = small_street();
  for (recording::ObjectRow& row : run.objects) {
    if (row.frame == 3 || row.track_id == 1) {
      row.status = BodyStatus::kStereoOnly;
    }
  }
  EXPECT_EQ(choose_object(open(run), 3, kImageWidth, kImageHeight), 2U);
  EXPECT_EQ(choose_object(open(straight_drive(3)), 1, kImageWidth, kImageHeight), std::nullopt);
}

}  // namespace
}  // namespace kinetrace::figure
