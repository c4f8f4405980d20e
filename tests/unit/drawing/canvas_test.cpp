#include <limits>
#include <vector>

#include "kinetrace/imaging/image_info.hpp"
#include "pixels.hpp"
#include "temp_folder.hpp"

namespace kinetrace::drawing {
namespace {

constexpr Color kBlack{0, 0, 0};
constexpr Color kWhite{255, 255, 255};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Canvas, BeginsInItsBackground) {
  const Canvas canvas(7, 5, kRed);
  EXPECT_EQ(canvas.width(), 7);
  EXPECT_EQ(canvas.height(), 5);
  EXPECT_EQ(count_near(canvas, kRed, 0), 35);
}

TEST(Canvas, RectanglesCoverPixelsByTheirShare) {
  Canvas canvas(10, 10, kWhite);
  canvas.rectangle({2.0, 3.5, 2.0, 1.5}, kBlack);
  EXPECT_EQ(canvas.at(2, 4), kBlack);
  EXPECT_TRUE(is_near(canvas.at(3, 3), {128, 128, 128}, 1));
  EXPECT_EQ(canvas.at(4, 4), kWhite);
  EXPECT_EQ(count_near(canvas, kWhite, 0), 100 - 4);
}

TEST(Canvas, AlphaMixesWithWhatIsThere) {
  Canvas canvas(4, 4, kWhite);
  canvas.rectangle({0, 0, 4, 4}, kBlack, 0.25);
  EXPECT_TRUE(is_near(canvas.at(1, 1), {191, 191, 191}, 1));
}

TEST(Canvas, LinesHaveTheWidthThatWasAskedFor) {
  // The ink of a horizontal line of 20 pixels, in whole pixels.
  for (const double width : {1.0, 1.5, 3.0}) {
    Canvas canvas(40, 20, kWhite);
    canvas.line({10.0, 10.0}, {30.0, 10.0}, {.color = kBlack, .width_px = width});
    double ink = 0.0;
    for (int y = 0; y < 20; ++y) {
      ink += (255 - canvas.at(20, y).r) / 255.0;
    }
    EXPECT_NEAR(ink, width, 0.3) << width;
  }
}

TEST(Canvas, CrossingPartsOfOneLineDoNotAddUp) {
  Canvas canvas(40, 40, kWhite);
  const std::vector<std::vector<Point>> cross{{{0.0, 20.0}, {40.0, 20.0}}, {{20.0, 0.0}, {20.0, 40.0}}};
  canvas.polylines(cross, {.color = kBlack, .width_px = 6.0, .alpha = 0.5});
  EXPECT_TRUE(is_near(canvas.at(20, 20), {128, 128, 128}, 2));
  EXPECT_TRUE(is_near(canvas.at(5, 20), {128, 128, 128}, 2));
}

TEST(Canvas, PointsThatAreNotFiniteInterruptALine) {
  Canvas canvas(40, 10, kWhite);
  const std::vector<Point> line{{2.0, 5.0}, {10.0, 5.0}, {kNan, 5.0}, {30.0, 5.0}, {38.0, 5.0}};
  canvas.polyline(line, {.color = kBlack, .width_px = 2.0});
  EXPECT_TRUE(is_near(canvas.at(6, 5), kBlack, 40));
  EXPECT_EQ(canvas.at(20, 5), kWhite);
  EXPECT_TRUE(is_near(canvas.at(34, 5), kBlack, 40));
}

TEST(Canvas, EndsFarOutsideDoNotMoveTheVisiblePart) {
  Canvas near(40, 40, kWhite);
  Canvas far(40, 40, kWhite);
  near.line({-40.0, -40.0}, {80.0, 80.0}, {.color = kBlack});
  far.line({-1e9, -1e9}, {1e9, 1e9}, {.color = kBlack});
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(is_near(near.at(i, i), far.at(i, i), 4)) << i;
  }
  EXPECT_TRUE(is_near(far.at(20, 20), kBlack, 60));
}

TEST(Canvas, DashedLinesHaveGapsAndEndQuicklyHoweverLong) {
  Canvas canvas(200, 10, kWhite);
  canvas.line({-1e9, 5.0}, {1e9, 5.0}, {.color = kBlack, .width_px = 2.0, .dash = Dash::kDashed});
  const int inked = count_near(canvas, {0, 4, 200, 1}, kBlack, 30);
  EXPECT_GT(inked, 80);
  EXPECT_LT(inked, 170);
}

TEST(Canvas, NothingOutsideTheClipChanges) {
  Canvas canvas(30, 30, kWhite);
  canvas.clip({10, 10, 10, 10});
  canvas.line({0, 0}, {30, 30}, {.color = kBlack, .width_px = 9.0});
  canvas.disk({15, 15}, 20.0, kBlack);
  canvas.text({5, 20}, "WWWWW", {.size_px = 14.0});
  EXPECT_EQ(count_near(canvas, kWhite, 0), 30 * 30 - 100);
  canvas.unclip();
  canvas.rectangle({0, 0, 30, 30}, kBlack);
  EXPECT_EQ(count_near(canvas, kBlack, 0), 900);
}

TEST(Canvas, DisksHaveTheirArea) {
  Canvas canvas(40, 40, kWhite);
  canvas.disk({20.0, 20.0}, 10.0, kBlack);
  double ink = 0.0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      ink += (255 - canvas.at(x, y).r) / 255.0;
    }
  }
  EXPECT_NEAR(ink, 314.0, 8.0);
  canvas.disk({kNan, 20.0}, 10.0, kRed);
  EXPECT_EQ(count_near(canvas, kRed), 0);
}

TEST(Canvas, PolygonsFillTheirInside) {
  Canvas canvas(20, 20, kWhite);
  const std::vector<Point> triangle{{2, 2}, {18, 2}, {2, 18}};
  canvas.polygon(triangle, kBlack);
  EXPECT_EQ(canvas.at(4, 4), kBlack);
  EXPECT_EQ(canvas.at(16, 16), kWhite);
  const std::vector<Point> wild{{-1e12, 5}, {1e12, 5}, {5, 1e12}};
  canvas.polygon(wild, kBlack);  // Must come back.
}

TEST(Canvas, TextStandsOnItsBaseLineAndGrowsWithItsSize) {
  Canvas canvas(120, 40, kWhite);
  const TextStyle style{.size_px = 10.0, .color = kBlack};
  canvas.text({10.0, 30.0}, "HHH", style);
  EXPECT_GT(count_near(canvas, {10, 20, 40, 10}, kBlack, 120), 20);
  EXPECT_EQ(count_near(canvas, {0, 32, 120, 8}, kWhite, 2), 120 * 8);
  EXPECT_EQ(count_near(canvas, {0, 0, 120, 18}, kWhite, 2), 120 * 18);
  TextStyle twice = style;
  twice.size_px = 20.0;
  EXPECT_NEAR(text_width("HHH", twice), 2.0 * text_width("HHH", style), 2.0);
}

TEST(Canvas, TextAnchorsAtItsRightAndTurns) {
  Canvas canvas(80, 80, kWhite);
  canvas.text({70.0, 20.0}, "HH", {.size_px = 10.0, .color = kBlack, .horizontal = HorizontalAnchor::kRight});
  EXPECT_EQ(count_near(canvas, {72, 0, 8, 80}, kWhite, 2), 8 * 80);
  EXPECT_GT(count_near(canvas, {40, 8, 32, 14}, kBlack, 120), 10);
  Canvas turned(80, 80, kWhite);
  turned.text({40.0, 70.0}, "HHHH", {.size_px = 10.0, .color = kBlack, .upwards = true});
  // Runs up from its anchor, left of it.
  EXPECT_GT(count_near(turned, {29, 30, 12, 40}, kBlack, 120), 20);
  EXPECT_EQ(count_near(turned, {43, 0, 37, 80}, kWhite, 2), 37 * 80);
}

TEST(Canvas, TextBeyondAsciiAndControlCharactersIsHarmless) {
  Canvas canvas(80, 20, kWhite);
  canvas.text({2.0, 15.0}, "", {});
  EXPECT_EQ(count_near(canvas, kWhite, 0), 80 * 20);
  // One sign for each character, not for each byte.
  EXPECT_EQ(text_width("\xc3\xa4\xc3\xa4", {}), text_width("??", {}));
  canvas.text({2.0, 15.0}, "\xc3\xa4\n\t", {});
  EXPECT_LT(count_near(canvas, kWhite, 0), 80 * 20);
}

TEST(Canvas, ShortenedTextFits) {
  const TextStyle style;
  EXPECT_EQ(shortened("short", 500.0, style), "short");
  const std::string cut = shortened("a rather long sentence that continues", 100.0, style);
  EXPECT_LE(text_width(cut, style), 100.0);
  EXPECT_TRUE(cut.ends_with(".."));
  EXPECT_GT(cut.size(), 5U);
}

TEST(Canvas, ImagesKeepTheirPixelsAtTheirOwnSize) {
  std::vector<std::uint8_t> pixels(12);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint8_t>(i * 20);
  }
  Canvas canvas(10, 10, kWhite);
  canvas.image({pixels.data(), 4, 3, 4}, {2, 3, 4, 3});
  EXPECT_EQ(canvas.at(2, 3), kBlack);
  EXPECT_EQ(canvas.at(5, 5), (Color{220, 220, 220}));
  EXPECT_EQ(canvas.at(6, 5), kWhite);
  canvas.image({pixels.data(), 4, 3, 4}, {2, 3, 4, 3}, 0.5);
  EXPECT_TRUE(is_near(canvas.at(2, 3), {128, 128, 128}, 1));
}

TEST(Canvas, MasksCoverTheirPixelsWhateverTheScale) {
  std::vector<std::uint8_t> pixels(16 * 16, 0);
  for (int y = 4; y < 12; ++y) {
    for (int x = 4; x < 12; ++x) {
      pixels[static_cast<std::size_t>(y * 16 + x)] = 9;
    }
  }
  const GrayView mask{pixels.data(), 16, 16, 16};
  for (const double size : {8.0, 16.0, 64.0}) {
    Canvas canvas(64, 64, kWhite);
    canvas.mask(mask, {0, 0, size, size}, kBlack, 1.0);
    double ink = 0.0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        ink += (255 - canvas.at(x, y).r) / 255.0;
      }
    }
    EXPECT_NEAR(ink, size * size / 4.0, size) << size;
    EXPECT_EQ(canvas.at(static_cast<int>(size / 2), static_cast<int>(size / 2)), kBlack) << size;
    EXPECT_EQ(canvas.at(0, 0), kWhite);
  }
}

TEST(Canvas, OutlinesFollowAMaskToTheEdgeOfTheImage) {
  const std::vector<std::uint8_t> full(20 * 20, 255);
  Canvas canvas(60, 60, kWhite);
  canvas.mask_outline({full.data(), 20, 20, 20}, {10, 10, 40, 40}, {.color = kBlack, .width_px = 2.0});
  EXPECT_GT(count_near(canvas, kBlack, 80), 100);
  EXPECT_EQ(canvas.at(30, 30), kWhite);
  const std::vector<std::uint8_t> none(20 * 20, 0);
  Canvas empty(60, 60, kWhite);
  empty.mask_outline({none.data(), 20, 20, 20}, {10, 10, 40, 40}, {.color = kBlack});
  EXPECT_EQ(count_near(empty, kWhite, 0), 3600);
}

TEST(Canvas, WritesPngOfItsSizeOrSaysWhyNot) {
  const test::TempFolder scratch;
  const Canvas canvas(33, 21, kRed);
  const std::filesystem::path file = scratch.path() / "picture.png";
  ASSERT_TRUE(canvas.write_png(file));
  const Result<imaging::ImageInfo> info = imaging::read_image_info(file.c_str());
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->width, 33);
  EXPECT_EQ(info->height, 21);
  EXPECT_EQ(info->channels, 3);
  const Status refused = canvas.write_png(scratch.path() / "no" / "folder.png");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace kinetrace::drawing
