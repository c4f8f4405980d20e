// The command `kinetrace figure` as a user meets it.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/image_info.hpp"
#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Figure : public ::testing::Test {
 protected:
  void SetUp() override {
    recording_.write();
    const ProgramResult run = run_kinetrace(
        {"run", "--dataset", recording_.dataset(), "--segmentation", "motion", "--quiet", "--out", run_.string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  [[nodiscard]] ProgramResult figure(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"figure", run_.string()});
    return run_kinetrace(more);
  }
  static void expect_size(const std::filesystem::path& png, int width, int least_height) {
    const Result<imaging::ImageInfo> info = imaging::read_image_info(png.c_str());
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->format, imaging::ImageFormat::kPng);
    EXPECT_EQ(info->width, width);
    EXPECT_GE(info->height, least_height);
    EXPECT_EQ(info->channels, 3);
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path run_ = scratch_.path() / "run";
};

TEST_F(Figure, IsAPngOf1600PixelsInTheRunFolder) {
  const ProgramResult result = figure();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out, HasSubstr((run_ / "figure.png").string()));
  expect_size(run_ / "figure.png", 1600, 1200);
}

TEST_F(Figure, IsWrittenWhereOutSays) {
  const std::filesystem::path file = scratch_.path() / "mine.png";
  const ProgramResult result = figure({"--frame", "2", "--out", file.string(), "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, IsEmpty());
  expect_size(file, 1600, 1200);
  EXPECT_FALSE(std::filesystem::exists(run_ / "figure.png"));
}

TEST_F(Figure, OverlayIsAPictureOfEachFrame) {
  const std::filesystem::path overlay = scratch_.path() / "overlay";
  const ProgramResult result = figure({"--overlay", overlay.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr(std::to_string(recording_.frames) + " pictures in"));
  for (int i = 0; i < recording_.frames; ++i) {
    expect_size(overlay / recording_.image(0, i).filename(), SmallRecording::kWidth, SmallRecording::kHeight);
  }
}

TEST_F(Figure, NothingButAnEarlierPictureIsReplaced) {
  const auto bytes = [](const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  const std::filesystem::path image = recording_.image(0, 0);
  const std::filesystem::path copies = scratch_.path() / "copies";
  std::filesystem::copy(image.parent_path(), copies);
  const auto expect_kept = [&](const std::vector<std::string>& more, const std::filesystem::path& file,
                               const std::string& text) {
    const std::string kept = bytes(file);
    const ProgramResult result = figure(more);
    EXPECT_EQ(result.exit_code, kCannotCreate) << more[0];
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(bytes(file), kept) << file;
  };
  expect_kept({"--overlay", image.parent_path().string()}, image, "lies among the recording's images");
  for (const std::filesystem::path& beside : {image.parent_path() / "mine", image.parent_path().parent_path()}) {
    expect_kept({"--overlay", beside.string()}, image, "lies among the recording's images");
  }
  expect_kept({"--film", recording_.image(1, 0).parent_path().string()}, recording_.image(1, 0), "name another folder");
  expect_kept({"--overlay", copies.string()}, copies / image.filename(), "is no picture of an earlier figure");
  expect_kept({"--out", image.string()}, image, "is no picture of an earlier figure");
  expect_kept({"--out", (run_ / "run.json").string()}, run_ / "run.json", "run.json: is there already");
  EXPECT_EQ(figure().exit_code, 0);
  EXPECT_EQ(figure().exit_code, 0) << "a picture is replaced";
}

TEST_F(Figure, ARecordingThatWasPlayedTwiceHasItsImagesInBothPasses) {
  const ProgramResult run =
      run_kinetrace({"run", "--dataset", recording_.dataset(), "--loop", "2", "--quiet", "--out", run_.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::filesystem::path overlay = scratch_.path() / "overlay";
  const ProgramResult result =
      figure({"--frame", std::to_string(2 * recording_.frames - 1), "--overlay", overlay.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out, HasSubstr(std::to_string(2 * recording_.frames) + " pictures in"));
  expect_size(overlay / (recording_.image(0, 0).stem().string() + "_pass2.png"), SmallRecording::kWidth,
              SmallRecording::kHeight);
}

// A run started with a relative recording path can be drawn from any folder.
TEST_F(Figure, ARelativeRecordingIsFoundFromAnyFolder) {
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(scratch_.path());
  const ProgramResult run =
      run_kinetrace({"run", "--dataset", "kitti-odometry:" + std::filesystem::relative(recording_.sequence()).string(),
                     "--quiet", "--out", run_.string()});
  std::filesystem::current_path(here);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramResult drawn = figure({"--overlay", (scratch_.path() / "overlay").string()});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
}

TEST_F(Figure, AFilmHasEveryFrameAboveTheTrajectories) {
  const std::filesystem::path film = scratch_.path() / "film";
  const ProgramResult result = figure({"--film", film.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  constexpr int kWidth = 720;
  constexpr int kBelow = 284;
  for (int i = 0; i < recording_.frames; ++i) {
    expect_size(film / recording_.image(0, i).filename(), kWidth,
                kWidth * SmallRecording::kHeight / SmallRecording::kWidth + kBelow);
  }
}

TEST_F(Figure, WithoutItsRecordingIsDrawnWithAWarning) {
  std::filesystem::remove_all(recording_.root);
  const ProgramResult result = figure();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("--dataset LAYOUT:PATH"));
  expect_size(run_ / "figure.png", 1600, 1200);
  // An overlay requires the recording.
  EXPECT_EQ(figure({"--overlay", (scratch_.path() / "overlay").string()}).exit_code, 66);
}

TEST_F(Figure, AnotherRecordingIsRefused) {
  const SmallRecording other{.root = scratch_.path() / "other", .step_m = 0.2};
  other.write();
  expect_refusal(figure({"--dataset", other.dataset()}), kBadData, other.dataset() + ": is another recording");
  EXPECT_FALSE(std::filesystem::exists(run_ / "figure.png"));
}

TEST_F(Figure, WrongUseIsSaidInOneLine) {
  const auto expect = [&](const std::vector<std::string>& arguments, int exit_code, const std::string& message) {
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  const std::string run = run_.string();
  expect({"figure"}, 64, "RUN");
  expect({"figure", run, "--frame", "6"}, 64, "frames 0 to 5");
  expect({"figure", run, "--frame", "six"}, 64, "--frame");
  expect({"figure", run, "--object", "77"}, 64, "--object 77");
  expect({"figure", run, "--dataset", "nothing"}, 64, "LAYOUT:PATH");
  expect({"figure", run, "--dataset", "kitti-odometry:" + scratch_.path().string()}, 66, scratch_.path().string());
  expect({"figure", scratch_.path().string()}, 66, "run.json");
  const std::string pictures = (scratch_.path() / "pictures").string();
  expect({"figure", run, "--overlay", pictures, "--film", pictures + "/../pictures/"}, 64, "name two folders");
  EXPECT_FALSE(std::filesystem::exists(pictures));
  expect({"figure", run, "--out", "/no/such/folder/x.png"}, 74, "/no/such/folder/x.png");
  expect({"figure", run, "--out", run}, 74, run + ": is a folder; name a file");
  expect({"figure", run, "--out", run + "/x.SVG"}, 64, "--out: " + run + "/x.SVG would be no svg; name it .png");
  expect({"figure", run + "/run.json"}, 66, run + "/run.json: is a file; expected the folder of a run");
}

TEST_F(Figure, ARunOfAContainerHasItsImages) {
  const std::filesystem::path container = scratch_.path() / "container";
  const std::filesystem::path camera = scratch_.path() / "camera.yaml";
  std::ofstream(camera) << "source: files\nfiles:\n  layout: kitti-odometry\n  path: " << recording_.sequence().string()
                        << "\n";
  const ProgramResult record =
      run_kinetrace({"record", "--camera", camera.string(), "--out", container.string(), "--container"});
  ASSERT_EQ(record.exit_code, 0) << record.err;
  const ProgramResult run = run_kinetrace({"run", "--dataset", "container:" + container.string(), "--segmentation",
                                           "motion", "--quiet", "--out", run_.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::filesystem::path overlay = scratch_.path() / "overlay";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{},
        {"--overlay", overlay.string()},
        {"--dataset", "container:" + container.string(), "--overlay", overlay.string()}}) {
    const ProgramResult result = figure(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, IsEmpty());
  }
  EXPECT_FALSE(std::filesystem::is_empty(overlay));
}

TEST_F(Figure, ARunThatWasKilledIsDrawnWithItsImagesAndAWarning) {
  Program run({"run", "--dataset", recording_.dataset(), "--segmentation", "motion", "--quiet", "--loop", "10000",
               "--out", run_.string()});
  const auto has_rows = [&] {
    std::error_code error;
    return std::filesystem::exists(run_ / ".spool" / "run.json", error) &&
           std::filesystem::file_size(run_ / "objects.csv", error) > 0 &&
           std::filesystem::file_size(run_ / "camera.tum", error) > 2000;
  };
  for (int i = 0; i < 600 && !has_rows(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const ProgramResult second = run_kinetrace(
      {"run", "--dataset", recording_.dataset(), "--segmentation", "motion", "--quiet", "--out", run_.string()});
  EXPECT_EQ(second.exit_code, 73);
  EXPECT_THAT(second.err, HasSubstr("another run writes into it"));
  const ProgramResult meanwhile = figure({"--frame", "2"});
  EXPECT_EQ(meanwhile.exit_code, 0) << meanwhile.err;
  EXPECT_THAT(meanwhile.err, HasSubstr("a run is still writing into it"));
  run.send(SIGKILL);
  EXPECT_EQ(run.wait().exit_code, 128 + SIGKILL);
  const ProgramResult after = figure({"--frame", "2"});
  EXPECT_EQ(after.exit_code, 0) << after.err;
  EXPECT_THAT(after.err, HasSubstr("the run did not end in good order"));
  EXPECT_THAT(after.err, Not(HasSubstr("no images")));
  expect_size(run_ / "figure.png", 1600, 1200);
}

TEST_F(Figure, PointsThatAreNoFileAreRefusedAndNamed) {
  const std::filesystem::path points = run_ / "points" / "background.ply";
  std::filesystem::remove(points);
  const auto expect_refused = [&] {
    const ProgramResult result = figure();
    EXPECT_EQ(result.exit_code, 65);
    EXPECT_THAT(result.err, HasSubstr(points.string() + ": is a "));
    EXPECT_THAT(result.err, HasSubstr("not a file; give the path of a file"));
    std::filesystem::remove(points);
  };
  std::filesystem::create_symlink("/dev/zero", points);
  expect_refused();
  ASSERT_EQ(::mkfifo(points.c_str(), 0600), 0);
  expect_refused();
  std::ofstream(points) << "ply\n" << std::string(1 << 20, 'x');
  EXPECT_EQ(figure().exit_code, 65);
}

}  // namespace
}  // namespace kinetrace::test
