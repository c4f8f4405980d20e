#include "target.hpp"

#include <fstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "target_drawing.hpp"
#include "temp_folder.hpp"

namespace kinetrace::calibration {
namespace {

using ::testing::HasSubstr;

TEST(Target, IsParsedFromItsShortForm) {
  const auto chessboard = parse_target("chessboard:9x6:0.025");
  ASSERT_TRUE(chessboard) << chessboard.error().message;
  EXPECT_EQ(chessboard->points_m.size(), 54U);
  EXPECT_EQ(chessboard->points_m[10], Eigen::Vector3d(0.025, 0.025, 0.0));
  EXPECT_EQ(chessboard->description(), "chessboard 9x6, squares of 0.025 m");
  const auto charuco = parse_target("charuco:8x6:0.04:0.03:DICT_5X5_100");
  ASSERT_TRUE(charuco) << charuco.error().message;
  EXPECT_EQ(charuco->points_m.size(), 35U);
  EXPECT_EQ(charuco->markers.size(), 24U);
  EXPECT_EQ(charuco->dictionary, "DICT_5X5_100");
  const auto grid = parse_target("aprilgrid:6x5:0.05:0.3");
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->points_m.size(), 120U);
  EXPECT_EQ(grid->border_bits, 2);
  // The first tag is the bottom left one.
  EXPECT_NEAR(grid->markers[0].corners_m[0].y(), 4 * 0.065, 1e-12);
}

TEST(Target, RefusesWhatIsNotUnderstood) {
  for (const char* text : {"", "chessboard", "chessboard:9x6", "chessboard:9:0.03", "chessboard:2x6:0.03",
                           "chessboard:9x6:x", "chessboard:9x6:30", "chessboard:9x6:nan", "chessboard:9x6:-1",
                           "chessboard:999x6:0.03", "charuco:9x6:0.03", "charuco:9x6:0.03:0.03", "aprilgrid:6x6:0.08",
                           "aprilgrid:6x6:0.08:0.3:3", "aprilgrid:1x6:0.08:0.3", "/no/such/file"}) {
    const auto target = parse_target(text);
    ASSERT_FALSE(target) << text;
    EXPECT_EQ(target.error().code, ErrorCode::kInvalidArgument) << text;
  }
}

TEST(Target, IsReadFromAFileOfKalibr) {
  const kinetrace::test::TempFolder folder;
  const std::string path = folder.file("target.yaml");
  const auto read = [&path](const std::string& text) {
    std::ofstream(path) << text;
    return parse_target(path);
  };
  const auto grid = read("target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n");
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_EQ(grid->kind, TargetKind::kAprilGrid);
  EXPECT_EQ(grid->rows, 5);
  const auto board = read(
      "target_type: 'checkerboard'\ntargetCols: 7\ntargetRows: 6\nrowSpacingMeters: 0.06\ncolSpacingMeters: 0.06\n");
  ASSERT_TRUE(board) << board.error().message;
  EXPECT_EQ(board->points_m.size(), 42U);
  const auto charuco = read(
      "target_type: charuco\nsquaresX: 8\nsquaresY: 6\nsquareLength: 0.04\nmarkerLength: 0.03\nlegacyPattern: true\n");
  ASSERT_TRUE(charuco) << charuco.error().message;
  EXPECT_EQ(charuco->dictionary, "DICT_4X4_100");
  for (const char* text : {"target_type: circlegrid\n", "tagCols: 6\n", "[", "target_type: aprilgrid\ntagCols: many\n",
                           "target_type: aprilgrid\ntagCols: 6\ntagRows: 5\ntagSize: 88\ntagSpacing: 0.3\n"}) {
    const auto bad = read(text);
    ASSERT_FALSE(bad) << text;
    EXPECT_EQ(bad.error().code, ErrorCode::kBadFormat) << text;
    EXPECT_THAT(bad.error().message, HasSubstr(path));
  }
  for (const char* text : {"", "some words\n", "- 6\n"}) {
    EXPECT_THAT(read(text).error().message, HasSubstr(path + ": is no target file; it says target_type"));
  }
}

TEST(Target, RefusesAFileThatSaysAThingTwice) {
  const kinetrace::test::TempFolder folder;
  const std::string path = folder.file("target.yaml");
  const std::string grid = "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n";
  for (const auto& [more, culprit] :
       {std::pair("tagSize: 0.044\n", "line 6: \"tagSize\" is already given in line 4; keep one"),
        std::pair("---\ntagSize: 0.044\n", "line 6: a second document begins here"),
        std::pair("borderBits: 3\n", "borderBits is 3; a tag's border has 1 or 2")}) {
    std::ofstream(path) << grid << more;
    const auto target = parse_target(path);
    ASSERT_FALSE(target) << more;
    EXPECT_EQ(target.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(target.error().message, HasSubstr(path + ": " + culprit));
  }
}

TEST(TargetDrawing, HasTheTrueSize) {
  const auto svg = target_svg(chessboard_target(9, 6, 0.03));
  ASSERT_TRUE(svg) << svg.error().message;
  // Ten by seven squares and a margin.
  EXPECT_THAT(*svg, HasSubstr("width=\"320.000mm\" height=\"230.000mm\""));
  EXPECT_THAT(*svg, HasSubstr("<rect x=\"10.0000\" y=\"10.0000\" width=\"30.0000\" height=\"30.0000\"/>"));
  EXPECT_EQ(black_rectangles(chessboard_target(9, 6, 0.03))->size(), 35U);
}

TEST(TargetDrawing, IsRecognised) {
  const kinetrace::test::TempFolder folder;
  std::ofstream(folder.file("board.svg")) << *target_svg(chessboard_target(9, 6, 0.03));
  std::ofstream(folder.file("other.svg")) << "<?xml version=\"1.0\"?>\n<svg/>\n";
  EXPECT_TRUE(is_target_svg(folder.file("board.svg")));
  EXPECT_FALSE(is_target_svg(folder.file("other.svg")));
  EXPECT_FALSE(is_target_svg(folder.file("none.svg")));
}

TEST(TargetDrawing, RefusesMoreMarkersThanADictionaryHas) {
  EXPECT_TRUE(target_svg(charuco_target(10, 10, 0.03, 0.02, "DICT_4X4_50")));
  const auto svg = target_svg(charuco_target(11, 10, 0.03, 0.02, "DICT_4X4_50"));
  ASSERT_FALSE(svg);
  EXPECT_THAT(svg.error().message, HasSubstr("DICT_4X4_50 has no marker 50"));
  EXPECT_FALSE(target_svg(april_grid_target(30, 30, 0.05, 0.3)));
  const auto unknown = target_svg(charuco_target(8, 6, 0.04, 0.03, "FOO"));
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("unknown dictionary 'FOO'; there are: DICT_4X4_50, DICT_4X4_100, "));
}

}  // namespace
}  // namespace kinetrace::calibration
