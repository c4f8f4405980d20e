#include "figure/same_recording.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/png_writer.hpp"
#include "kinetrace/recording/observations.hpp"
#include "run_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::figure {
namespace {

using recording::Observation;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kFrames = 10;
constexpr double kStep_px = 2.7;

/// A run past a wall that never repeats itself, and recordings of it.
class SameRecording : public ::testing::Test {
 protected:
  SameRecording() {
    run_ = straight_drive(kFrames);
    run_.directory = scratch_.path() / "run";
    run_.is_finished = false;  // Its observations are not counted in a run.json.
    run_.dataset = record("own", kStep_px);
    std::filesystem::create_directories(run_.directory);
  }

  /// A recording in which the wall moves by so many pixels a frame; returns LAYOUT:PATH.
  std::string record(const std::string& name, double step_px) {
    std::string dataset = write_recording(scratch_.path() / name, kFrames);
    for (const char* view : {"image_0", "image_1"}) {
      for (int frame = 0; frame < kFrames; ++frame) {
        std::array<char, 16> file{};
        std::snprintf(file.data(), file.size(), "%06d.png", frame);
        const std::vector<std::uint8_t> pixels = wall(step_px * frame);
        const Status written = imaging::write_png_gray8((scratch_.path() / name / view / file.data()).c_str(),
                                                        {pixels.data(), kImageWidth, kImageHeight, kImageWidth});
        EXPECT_TRUE(written) << written.error().message;
      }
    }
    return dataset;
  }

  static std::vector<std::uint8_t> wall(double moved_px) {
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < kImageHeight; ++y) {
      for (int i = 0; i < kImageWidth; ++i) {
        const double x = i - moved_px;
        pixels.push_back(static_cast<std::uint8_t>(std::lround(128.0 + 35.0 * std::sin(0.45 * x + 0.21 * y) +
                                                               30.0 * std::sin(0.37 * y - 0.16 * x + 1.0) +
                                                               20.0 * std::sin(0.083 * x + 0.3))));
      }
    }
    return pixels;
  }

  void observe_wall() const {
    std::ofstream file(run_.directory / "observations.bin", std::ios::binary);
    file << "kinetrace observations\n1";
    for (int frame = 0; frame < kFrames; ++frame) {
      for (std::uint32_t id = 1; id <= 48; ++id) {
        const Observation seen{.track_id = 0,
                               .point_id = id,
                               .frame = frame,
                               .u_left_px = static_cast<float>(30.25 + 20.0 * (id % 12) + kStep_px * frame),
                               .v_px = static_cast<float>(20.5 + 30.0 * (id / 12)),
                               .u_right_px = std::nanf("")};
        file.write(reinterpret_cast<const char*>(&seen),
                   sizeof seen);  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
      }
    }
  }

  void shift_times() {
    for (recording::CameraRow& row : run_.camera) {
      row.timestamp_ns += 3'600'000'000'000;
    }
  }

  test::TempFolder scratch_;
  recording::Run run_;
};

TEST_F(SameRecording, IsRecognisedByWhatTheRunSaw) {
  observe_wall();
  EXPECT_TRUE(RecordedImages::open(run_, ""));
  EXPECT_TRUE(RecordedImages::open(run_, record("copy", kStep_px)));
  const auto other = RecordedImages::open(run_, record("other", 0.4 * kStep_px));
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(other.error().message, AllOf(HasSubstr((scratch_.path() / "other").string() + ": is another recording"),
                                           HasSubstr(run_.dataset), HasSubstr(" points of the run are in its images")));
}

TEST_F(SameRecording, MayHaveLostItsTimes) {
  observe_wall();
  shift_times();
  EXPECT_TRUE(RecordedImages::open(run_, ""));
}

TEST_F(SameRecording, IsRecognisedByItsTimesWithoutObservations) {
  EXPECT_TRUE(RecordedImages::open(run_, record("other", 0.4 * kStep_px)));
  shift_times();
  const auto other = RecordedImages::open(run_, "");
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("0 of 10 times of its frames are the run's"));
}

TEST_F(SameRecording, HasImagesOfTheSameSize) {
  run_.rectified = {
      .fx_px = 40.0, .fy_px = 41.0, .cx_px = 16.0, .cy_px = 8.0, .baseline_m = 0.5, .width_px = 32, .height_px = 16};
  const auto other = RecordedImages::open(run_, "");
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("not of the same size"));
}

}  // namespace
}  // namespace kinetrace::figure
