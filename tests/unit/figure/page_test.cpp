#include <fstream>

#include "figure/figure_page.hpp"
#include "pixels.hpp"
#include "run_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::figure {
namespace {

using ::testing::HasSubstr;

/// A run folder on disk with the recording that it was made from.
class Page : public ::testing::Test {
 protected:
  Page() {
    write_run(small_street(), run_folder_, write_recording(scratch_.path() / "recording", 10));
    write_cloud(run_folder_ / "points" / "background.ply", 12, 3.0);
    write_cloud(run_folder_ / "points" / "object_1_model.ply", 5, 0.5);
  }

  Result<Scene> scene(const SceneChoice& choice = {}, const std::string& moved_to = "") {
    Result<FigureRun> run = FigureRun::open(run_folder_);
    EXPECT_TRUE(run) << run.error().message;
    run_ = std::make_unique<FigureRun>(std::move(*run));
    Result<recording::MaskFrames> masks = recording::MaskFrames::open(run_->run());
    EXPECT_TRUE(masks) << masks.error().message;
    Result<RecordedImages> images = RecordedImages::open(run_->run(), moved_to);
    return make_scene(*run_, choice, images ? &*images : nullptr, images ? "" : images.error().message, *masks);
  }

  test::TempFolder scratch_;
  std::filesystem::path run_folder_ = scratch_.path() / "run";
  std::unique_ptr<FigureRun> run_;
};

TEST_F(Page, TakesImagesMasksAndPointsFromTheFolder) {
  const Result<Scene> scene = this->scene();
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->frame, 0);
  EXPECT_EQ(scene->object, 1U);
  EXPECT_EQ(scene->geometry.width_px, kImageWidth);
  EXPECT_DOUBLE_EQ(scene->geometry.fx_px, 200.0);
  EXPECT_EQ(scene->image_view().at(10, 10), 90);
  EXPECT_EQ(scene->masks.size(), 3U);
  EXPECT_EQ(scene->masks[0].box_px.x0, 120);
  EXPECT_EQ(scene->mask_view(scene->masks[0]).at(150, 80), 255);
  EXPECT_EQ(scene->mask_view(scene->masks[0]).at(119, 80), 0);
  EXPECT_EQ(scene->background.points.size(), 1728U);
  EXPECT_EQ(scene->object_model.points.size(), 125U);
}

TEST_F(Page, IsAsWideAsPromisedAndShowsTracksInTheirColours) {
  const Result<Scene> scene = this->scene();
  ASSERT_TRUE(scene) << scene.error().message;
  const drawing::Canvas page = draw_page(*scene);
  EXPECT_EQ(page.width(), kPageWidth_px);
  EXPECT_GT(page.height(), 1000);
  for (const std::uint32_t id : {1U, 2U, 3U}) {
    EXPECT_GT(count_near(page, drawing::track_style(id).color), 40) << id;
  }
  // Margins stay clean.
  EXPECT_EQ(count_near(page, {0, 0, 20, static_cast<double>(page.height())}, drawing::kPaper, 0), 20 * page.height());
  EXPECT_EQ(count_near(page, {1580, 0, 20, static_cast<double>(page.height())}, drawing::kPaper, 0),
            20 * page.height());
}

TEST_F(Page, IsTheSameEachTime) {
  const Result<Scene> scene = this->scene();
  ASSERT_TRUE(scene);
  const drawing::Canvas a = draw_page(*scene);
  const drawing::Canvas b = draw_page(*scene);
  ASSERT_EQ(a.height(), b.height());
  int different = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      different += a.at(x, y) == b.at(x, y) ? 0 : 1;
    }
  }
  EXPECT_EQ(different, 0);
}

TEST_F(Page, FollowsTheChoice) {
  const Result<Scene> scene = this->scene({.frame = 7, .object = 2});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->frame, 7);
  EXPECT_EQ(scene->object, 2U);
  EXPECT_EQ(scene->masks.size(), 2U) << "the pedestrian is lost";
  EXPECT_TRUE(scene->object_model.points.empty()) << "no file, no points";
  EXPECT_EQ(draw_page(*scene).width(), kPageWidth_px);
}

TEST_F(Page, RefusesFramesAndObjectsThatTheRunDoesNotHave) {
  for (const std::int64_t frame : {-1, 10}) {
    const Result<Scene> scene = this->scene({.frame = frame, .object = {}});
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(scene.error().message, HasSubstr("frames 0 to 9"));
  }
  const Result<Scene> scene = this->scene({.frame = {}, .object = 44});
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().message, HasSubstr("the objects 1, 2, 3"));
}

TEST_F(Page, IsDrawnWithoutImages) {
  std::filesystem::remove_all(scratch_.path() / "recording");
  const Result<Scene> scene = this->scene();
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->image.empty());
  EXPECT_THAT(scene->image_problem, HasSubstr("no such folder"));
  EXPECT_EQ(scene->geometry.width_px, kImageWidth) << "from the masks";
  EXPECT_GT(count_near(draw_page(*scene), drawing::track_style(1).color), 40);
}

TEST_F(Page, TakesTheRecordingFromWhereItLiesNow) {
  const std::filesystem::path moved = scratch_.path() / "moved";
  std::filesystem::rename(scratch_.path() / "recording", moved);
  const Result<Scene> scene = this->scene({}, "kitti-odometry:" + moved.string());
  ASSERT_TRUE(scene);
  EXPECT_FALSE(scene->image.empty());
}

TEST_F(Page, SaysWhenAFrameHasNoImage) {
  std::filesystem::remove(scratch_.path() / "recording" / "image_0" / "000004.png");
  const Result<Scene> scene = this->scene({.frame = 4, .object = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->image.empty());
  EXPECT_THAT(scene->image_problem, HasSubstr("no frame 4"));
}

TEST_F(Page, RefusesAnotherRecordingThanTheRuns) {
  const std::filesystem::path other = scratch_.path() / "other";
  const std::string dataset = write_recording(other, 10);
  recording::Run run = small_street();
  write_run(run, run_folder_, dataset);
  std::ofstream(run_folder_ / "mots.txt") << "0 1001 1 4 4 4<\n";
  const Result<Scene> scene = this->scene();
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().message, HasSubstr("--dataset must name"));
}

TEST_F(Page, RunsWithoutObjectsAndOfOneFrameAreDrawn) {
  for (const int frames : {1, 10}) {
    write_run(straight_drive(frames), run_folder_, write_recording(scratch_.path() / "recording", 10));
    std::filesystem::remove_all(run_folder_ / "points");
    const Result<Scene> scene = this->scene();
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->object, std::nullopt);
    EXPECT_EQ(draw_page(*scene).width(), kPageWidth_px);
  }
}

TEST_F(Page, DamagedPointsAreAnError) {
  std::ofstream(run_folder_ / "points" / "background.ply") << "damaged";
  const Result<Scene> scene = this->scene();
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().message, HasSubstr("background.ply"));
}

TEST(RecordedGeometry, IsTheRunsWhereItSaysSo) {
  const std::vector<std::uint8_t> pixels(32 * 16);
  const LabelView labels{pixels.data(), 32, 16, 32};
  recording::Run run;
  EXPECT_EQ(recorded_geometry(run, labels).width_px, 32);
  EXPECT_DOUBLE_EQ(recorded_geometry(run, labels).fx_px, 16.0);
  EXPECT_GT(recorded_geometry(run, {}).width_px, 0);
  run.rectified = {
      .fx_px = 40.0, .fy_px = 41.0, .cx_px = 16.0, .cy_px = 8.0, .baseline_m = 0.5, .width_px = 32, .height_px = 16};
  EXPECT_DOUBLE_EQ(recorded_geometry(run, labels).fx_px, 40.0);
  EXPECT_DOUBLE_EQ(recorded_geometry(run, labels).cy_px, 8.0);
}

}  // namespace
}  // namespace kinetrace::figure
