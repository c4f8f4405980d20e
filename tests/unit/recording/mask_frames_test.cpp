#include "kinetrace/recording/mask_frames.hpp"

#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

using ::testing::HasSubstr;

/// A folder with a mots.txt of images of 3 x 3 pixels, written by hand.
class RunMasks : public ::testing::Test {
 protected:
  void write(const std::string& text) { std::ofstream(folder_.path() / "mots.txt") << text; }
  Result<MaskFrames> open() { return MaskFrames::open({.directory = folder_.path()}); }
  /// Error message of reading frame 0.
  std::string error_of(const std::string& text, ErrorCode code) {
    write(text);
    Result<MaskFrames> frames = open();
    if (!frames) {
      EXPECT_EQ(frames.error().code, code);
      return frames.error().message;
    }
    const Result<MaskFrame> frame = frames->at(0);
    EXPECT_FALSE(frame);
    EXPECT_EQ(frame.error().code, code);
    return frame.error().message;
  }

  TemporaryFolder folder_;
};

TEST_F(RunMasks, PaintsEachFrameInAnyOrder) {
  // 41110: pixels 4, 6, 7 down the columns = (1,1), (2,0), (2,1); 012 -> background 0, 1 pixel, ...
  write("0 1001 1 3 3 41110\n0 2007 2 3 3 018\n4 100001234 0 3 3 72\n");
  Result<MaskFrames> frames = open();
  ASSERT_TRUE(frames) << frames.error().message;
  const MaskFrame last = *frames->at(4);
  ASSERT_EQ(last.masks.size(), 1U);
  EXPECT_EQ(last.masks[0].track_id, 1234U);
  EXPECT_EQ(last.masks[0].class_id, 0);
  EXPECT_EQ(last.masks[0].area_px, 2);

  const MaskFrame first = *frames->at(0);
  ASSERT_EQ(first.masks.size(), 2U);
  EXPECT_EQ(first.masks[0].track_id, 1U);
  EXPECT_EQ(first.masks[0].area_px, 3);
  EXPECT_EQ(first.masks[0].box_px.x0, 1);
  EXPECT_EQ(first.masks[0].box_px.y0, 0);
  EXPECT_EQ(first.masks[0].box_px.x1, 3);
  EXPECT_EQ(first.masks[0].box_px.y1, 2);
  EXPECT_EQ(first.masks[1].track_id, 7U);
  EXPECT_EQ(first.masks[1].class_id, 2);
  const std::vector<int> expected{2, 0, 1, 0, 1, 1, 0, 0, 0};
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(first.labels.at(i % 3, i / 3), expected[static_cast<std::size_t>(i)]) << i;
  }

  const MaskFrame between = *frames->at(2);
  EXPECT_TRUE(between.masks.empty());
  EXPECT_EQ(between.labels.width, 3);
  EXPECT_EQ(between.labels.at(0, 0), kBackgroundLabel);
}

TEST_F(RunMasks, HasNoMasksWithoutAFileOrRows) {
  EXPECT_TRUE(open()->at(0)->masks.empty());
  write("");
  EXPECT_TRUE(open()->at(0)->masks.empty());
  EXPECT_TRUE(open()->at(0)->labels.empty());
}

TEST_F(RunMasks, RefusesWhatCannotBeOneImageAndSaysWhere) {
  EXPECT_THAT(error_of("0 1001 1 3 3 4111\n", ErrorCode::kBadFormat),
              HasSubstr("mots.txt, frame 0, track 1: run-length string, character 5: fewer pixels"));
  EXPECT_THAT(error_of("0 1001 1 3 3 018\n0 1002 1 3 3 018\n", ErrorCode::kBadFormat),
              HasSubstr("frame 0, track 2: covers pixels of another mask"));
  EXPECT_THAT(error_of("0 1001 1 3 3 018\n0 2001 2 3 3 117\n", ErrorCode::kBadFormat),
              HasSubstr("frame 0, track 1: has two masks"));
  EXPECT_THAT(error_of("0 1001 1 3 3 018\n3 1001 1 3 4 018\n", ErrorCode::kBadFormat),
              HasSubstr("frame 3, track 1: an image of 4 x 3 pixels, not 3 x 3 as before"));
  EXPECT_THAT(error_of("0 1001 2 3 3 018\n", ErrorCode::kBadFormat), HasSubstr("mots.txt, line 1: obj_id 1001"));
}

TEST_F(RunMasks, Takes254MasksAndRefusesOneMore) {
  // One row of pixels of which mask k holds pixel k: k zeros, a one, the rest; numbers up to 255 take two characters.
  const auto number = [](int value) {
    std::string text;
    for (bool more = true; more;) {
      const int group = value & 31;
      value >>= 5;
      more = (group & 16) != 0 ? value != -1 : value != 0;
      text += static_cast<char>(48 + group + (more ? 32 : 0));
    }
    return text;
  };
  std::string text;
  for (int k = 0; k < 255; ++k) {
    text += "0 " + std::to_string(1000 + k) + " 1 1 300 " + number(k) + number(1) + number(299 - k) + "\n";
    if (k == 253) {
      write(text);
      Result<MaskFrames> frames = open();
      ASSERT_TRUE(frames);
      EXPECT_EQ(frames->at(0)->masks.size(), 254U);
      EXPECT_EQ(frames->at(0)->labels.at(253, 0), 254);
    }
  }
  EXPECT_THAT(error_of(text, ErrorCode::kCapacity), HasSubstr("more than 254 masks"));
}

TEST_F(RunMasks, ReadsWhatTheRecorderWrote) {
  RecorderFixture fixture(recording_config(folder_.path() / "run"));
  SyntheticRunConfig config;
  config.objects = {{.track_id = 3}, {.track_id = 2000, .class_id = 2, .first_frame = 5}};
  SyntheticRun run(config);
  ASSERT_TRUE(run.play(*fixture.recorder));
  ASSERT_TRUE(fixture.recorder->finish({}));
  Result<MaskFrames> frames = MaskFrames::open({.directory = folder_.path() / "run"});
  ASSERT_TRUE(frames) << frames.error().message;
  EXPECT_EQ(frames->at(4)->masks.size(), 1U);
  const MaskFrame frame = *frames->at(5);
  ASSERT_EQ(frame.masks.size(), 2U);
  EXPECT_EQ(frame.masks[1].track_id, 2000U);
  for (std::size_t slot = 0; slot < 2; ++slot) {
    const PixelBox expected = SyntheticRun::mask_box(slot, 5);
    const PixelBox found = frame.masks[slot].box_px;
    EXPECT_EQ(std::make_tuple(found.x0, found.y0, found.x1, found.y1),
              std::make_tuple(expected.x0, expected.y0, expected.x1, expected.y1));
    EXPECT_EQ(frame.masks[slot].area_px, std::int64_t{expected.width()} * expected.height());
  }
}

}  // namespace
}  // namespace kinetrace::recording
