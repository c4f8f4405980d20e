#include "figure/figure_overlay.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "pixels.hpp"
#include "run_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::figure {
namespace {

using drawing::track_style;
using ::testing::HasSubstr;

constexpr StereoGeometry kGeometry{200.0, 200.0, 160.0, 80.0, 0.5, kImageWidth, kImageHeight};

class Overlay : public ::testing::Test {
 protected:
  drawing::Canvas draw(recording::Run run, std::int64_t frame, const std::vector<TrackMask>& masks = {}) {
    return draw_overlay(open(std::move(run)), frame, {gray_.data(), kImageWidth, kImageHeight, kImageWidth}, kGeometry,
                        masks);
  }
  static TrackMask mask_of(std::uint32_t id, const PixelBox& box) {
    TrackMask mask{id, 1, box, std::vector<std::uint8_t>(std::size_t{kImageWidth} * kImageHeight, 0)};
    for (int y = box.y0; y < box.y1; ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        mask.pixels[static_cast<std::size_t>(y * kImageWidth + x)] = 255;
      }
    }
    return mask;
  }
  /// One object ten metres ahead, whose box is 4 m long across the view.
  static recording::Run one_object(BodyStatus status) {
    recording::Run run = straight_drive(3);
    run.objects.push_back(object_row(0, 1, {0.0, 0.0, 10.0}));
    run.objects.back().status = status;
    return run;
  }

  std::vector<std::uint8_t> gray_ = std::vector<std::uint8_t>(std::size_t{kImageWidth} * kImageHeight, 90);
};

constexpr drawing::Color kGray{90, 90, 90};

TEST_F(Overlay, LeavesAPictureWithoutObjectsAlone) {
  const drawing::Canvas canvas = draw(straight_drive(3), 1);
  EXPECT_EQ(canvas.width(), kImageWidth);
  EXPECT_EQ(canvas.height(), kImageHeight);
  // Only the strip with frame and time is drawn.
  EXPECT_EQ(count_near(canvas, {0, 0, kImageWidth, 140}, kGray, 0), kImageWidth * 140);
}

TEST_F(Overlay, TintsMasks) {
  const drawing::Canvas canvas = draw(straight_drive(3), 1, {mask_of(5, {100, 50, 140, 90})});
  const drawing::Color tinted = drawing::mix(kGray, track_style(5).color, 0.38);
  EXPECT_TRUE(drawing::is_near(canvas.at(120, 80), tinted, 2));
  EXPECT_EQ(canvas.at(150, 80), kGray);
  // The name appears above the mask, though the object has no row yet.
  EXPECT_GT(count_near(canvas, {90, 30, 60, 19}, track_style(5).color, 30), 100);
}

TEST_F(Overlay, DrawsTheBoxOfATrackedObjectWhereItProjects) {
  const drawing::Canvas canvas = draw(one_object(BodyStatus::kTracked), 0);
  // Front face: z = 9, x = -2..2, y = -0.75..0.75.
  const double left = 160.5 - 200.0 * 2.0 / 9.0;
  const double top = 80.5 - 200.0 * 0.75 / 9.0;
  const drawing::Color color = track_style(1).color;
  EXPECT_GT(count_near(canvas, {left - 2, 72, 5, 16}, color, 25), 8);
  EXPECT_GT(count_near(canvas, {130, top - 2, 60, 5}, color, 25), 20);
}

TEST_F(Overlay, DrawsNoBoxUnlessTracked) {
  const drawing::Canvas stereo = draw(one_object(BodyStatus::kStereoOnly), 0);
  EXPECT_EQ(count_near(stereo, {100, 85, 120, 20}, track_style(1).color, 25), 0);
  EXPECT_GT(count_near(stereo, {100, 40, 120, 45}, track_style(1).color, 30), 50) << "but its name";
  const drawing::Canvas lost = draw(one_object(BodyStatus::kLost), 0);
  EXPECT_EQ(count_near(lost, {0, 0, kImageWidth, 140}, kGray, 0), kImageWidth * 140);
}

TEST_F(Overlay, ShowsWhereAMovingObjectCameFrom) {
  recording::Run run = straight_drive(3);
  for (recording::CameraRow& row : run.camera) {
    row.T_world_cam = {};
  }
  for (int i = 0; i < 3; ++i) {
    run.objects.push_back(object_row(i, 1, {-4.0 + 2.0 * i, 0.0, 10.0}));
    run.objects.back().moving = true;
    run.objects.back().status = BodyStatus::kStereoOnly;
  }
  const drawing::Canvas moving = draw(run, 2);
  // The trail: from x = -4 m to 0 at 10 m, a line of 80 pixels at half height.
  EXPECT_GT(count_near(moving, {84, 79, 70, 4}, track_style(1).color, 25), 60);
  for (recording::ObjectRow& row : run.objects) {
    row.moving = false;
  }
  EXPECT_EQ(count_near(draw(run, 2), {84, 79, 30, 4}, track_style(1).color, 25), 0);
}

TEST_F(Overlay, IgnoresWhatIsBehindTheCamera) {
  recording::Run run = straight_drive(3);
  run.objects.push_back(object_row(0, 1, {0.0, 0.0, -10.0}));
  run.objects.back().moving = true;
  EXPECT_EQ(count_near(draw(run, 0), {0, 0, kImageWidth, 140}, kGray, 0), kImageWidth * 140);
}

class OverlayFiles : public ::testing::Test {
 protected:
  void open_all(int images) {
    write_run(small_street(), scratch_.path() / "run", write_recording(scratch_.path() / "recording", images));
    run_ = std::make_unique<FigureRun>(std::move(*FigureRun::open(scratch_.path() / "run")));
    masks_ = std::make_unique<recording::MaskFrames>(std::move(*recording::MaskFrames::open(run_->run())));
    images_ = std::make_unique<RecordedImages>(std::move(*RecordedImages::open(run_->run(), "")));
  }
  test::TempFolder scratch_;
  std::filesystem::path out_ = scratch_.path() / "a" / "overlay";
  std::unique_ptr<FigureRun> run_;
  std::unique_ptr<recording::MaskFrames> masks_;
  std::unique_ptr<RecordedImages> images_;
};

TEST_F(OverlayFiles, HaveTheNamesAndSizeOfTheImages) {
  open_all(10);
  int calls = 0;
  const Result<std::int64_t> written =
      write_overlay(*run_, *images_, *masks_, out_, [&](std::int64_t frames, int objects) {
        EXPECT_EQ(frames, ++calls);
        EXPECT_EQ(objects, frames <= 5 ? 3 : 2);
        return true;
      });
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(*written, 10);
  EXPECT_EQ(calls, 10);
  for (const char* name : {"000000.png", "000009.png"}) {
    const Result<imaging::ImageInfo> info = imaging::read_image_info((out_ / name).c_str());
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->width, kImageWidth);
    EXPECT_EQ(info->height, kImageHeight);
    EXPECT_EQ(info->channels, 3);
  }
}

TEST_F(OverlayFiles, LeaveOutFramesWithoutImage) {
  open_all(4);
  const auto written = write_overlay(*run_, *images_, *masks_, out_, [](std::int64_t, int) { return true; });
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(*written, 4);
  EXPECT_FALSE(std::filesystem::exists(out_ / "000004.png"));
}

TEST_F(OverlayFiles, OfALaterPassAreNamedByIt) {
  open_all(5);
  recording::Run run = run_->run();
  run.passes = 2;
  RecordedImages images = std::move(*RecordedImages::open(run, ""));
  const auto written = write_overlay(*run_, images, *masks_, out_, [](std::int64_t, int) { return true; });
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(*written, 10);
  EXPECT_TRUE(std::filesystem::exists(out_ / "000000.png"));
  EXPECT_TRUE(std::filesystem::exists(out_ / "000004_pass2.png"));
  EXPECT_FALSE(images.left(10)) << "there is no third pass";
}

TEST_F(OverlayFiles, NeverTakeThePlaceOfTheRecordingsImagesNorOfCopiesOfThem) {
  open_all(2);
  const std::filesystem::path copies = scratch_.path() / "copies";
  std::filesystem::copy(images_->frames().left().folder, copies);
  for (const std::filesystem::path& folder : {std::filesystem::path(images_->frames().left().folder),
                                              std::filesystem::path(images_->frames().right().folder), copies}) {
    const auto written = write_overlay(*run_, *images_, *masks_, folder, [](std::int64_t, int) { return true; });
    ASSERT_FALSE(written) << folder;
    EXPECT_EQ(written.error().code, ErrorCode::kOccupied);
    EXPECT_THAT(written.error().message, HasSubstr("name another"));
    EXPECT_EQ(imaging::read_image_info((folder / "000000.png").c_str())->channels, 1) << folder;
  }
  for (int again = 0; again < 2; ++again) {
    EXPECT_EQ(*write_overlay(*run_, *images_, *masks_, out_, [](std::int64_t, int) { return true; }), 2);
  }
}

TEST_F(OverlayFiles, EndWhenTheCallerEndsThem) {
  open_all(10);
  EXPECT_EQ(*write_overlay(*run_, *images_, *masks_, out_, [](std::int64_t frames, int) { return frames < 3; }), 3);
}

TEST_F(OverlayFiles, NeedAFolder) {
  open_all(2);
  const Result<std::int64_t> written = write_overlay(*run_, *images_, *masks_, scratch_.path() / "run" / "run.json",
                                                     [](std::int64_t, int) { return true; });
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, HasSubstr("--overlay"));
}

}  // namespace
}  // namespace kinetrace::figure
