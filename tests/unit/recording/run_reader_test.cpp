#include "kinetrace/recording/run_reader.hpp"

#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A finished run of 12 frames with a car, a pedestrian from frame 3 on, and a short-lived object of another class.
class RunReader : public ::testing::Test {
 protected:
  void SetUp() override {
    SyntheticRunConfig config;
    config.frames = kFrames;
    config.objects = {{.track_id = 1, .class_id = 1, .first_frame = 0, .last_frame = 7},
                      {.track_id = 4, .class_id = 2, .first_frame = 3, .status = BodyStatus::kStereoOnly},
                      {.track_id = 1234, .class_id = 7, .first_frame = 2, .last_frame = 5}};
    RecorderFixture fixture(recording_config(run_path()));
    ASSERT_TRUE(fixture.recorder) << fixture.recorder.error().message;
    ASSERT_TRUE(SyntheticRun(config).play(*fixture.recorder));
    RunSummary summary;
    summary.dataset = {{"dataset", "folder:somewhere"}, {"sequence", "07"}};
    summary.config_json = R"({"output":{"mots":true}})";
    summary.frames = kFrames;
    ASSERT_TRUE(fixture.recorder->finish(summary));
  }
  [[nodiscard]] std::filesystem::path run_path() const { return folder_.path() / "run"; }
  /// Replaces a file by what `edit` makes of its lines.
  void edit(const char* name, const std::function<void(std::vector<std::string>&)>& change) const {
    std::vector<std::string> lines = read_lines(run_path() / name);
    change(lines);
    std::ofstream file(run_path() / name);
    for (const std::string& line : lines) {
      file << line << '\n';
    }
  }
  [[nodiscard]] std::string error() const {
    const Result<recording::Run> run = read_run(run_path());
    EXPECT_FALSE(run);
    return run ? "" : run.error().message;
  }
  [[nodiscard]] std::vector<std::int64_t> camera_frames() const {
    std::vector<std::int64_t> frames;
    const Result<recording::Run> run = read_run(run_path());
    for (const CameraRow& row : run.value().camera) {
      frames.push_back(row.frame);
    }
    return frames;
  }

  static constexpr int kFrames = 12;
  TemporaryFolder folder_;
};

TEST_F(RunReader, GivesBackWhatWasRecorded) {
  const Result<recording::Run> run = read_run(run_path());
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_EQ(run->dataset, "folder:somewhere");
  EXPECT_EQ(run->sequence, "07");
  EXPECT_EQ(run->config_json, R"({"output":{"mots":true}})");
  EXPECT_EQ(run->frames, kFrames);
  ASSERT_EQ(run->camera.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const CameraRow& row = run->camera[static_cast<std::size_t>(i)];
    EXPECT_EQ(row.frame, i);
    EXPECT_EQ(row.timestamp_ns, SyntheticRun::timestamp_ns(i));
    EXPECT_LT(left_difference(row.T_world_cam, SyntheticRun::T_world_cam(i)).norm(), 1e-7);
  }
  ASSERT_EQ(run->objects.size(), 8U + 9U + 4U);
  for (const ObjectRow& row : run->objects) {
    const int frame = static_cast<int>(row.frame);
    EXPECT_EQ(row.timestamp_ns, SyntheticRun::timestamp_ns(frame));
    EXPECT_LT(left_difference(row.T_world_obj, SyntheticRun::T_world_obj(row.track_id, frame)).norm(), 2e-6);
    const Box3 box = SyntheticRun::box(row.track_id, frame);
    EXPECT_LT((row.box.center_m - box.center_m).norm(), 2e-6);
    EXPECT_LT((row.box.size_m - box.size_m).norm(), 2e-6);
    EXPECT_NEAR(row.box.yaw_rad, box.yaw_rad, 1e-6);
    EXPECT_EQ(row.class_id, row.track_id == 1 ? 1 : row.track_id == 4 ? 2 : 7);
    EXPECT_EQ(row.status, row.track_id == 4 ? BodyStatus::kStereoOnly : BodyStatus::kTracked);
    EXPECT_EQ(row.mask_px.height(), row.pixel_height);
  }
}

TEST_F(RunReader, GivesMasksByFrame) {
  const Result<std::vector<MaskRow>> masks = read_masks(run_path());
  ASSERT_TRUE(masks) << masks.error().message;
  ASSERT_FALSE(masks->empty());
  std::int64_t last_frame = 0;
  bool has_large_id = false;
  for (const MaskRow& mask : *masks) {
    EXPECT_GE(mask.frame, last_frame);
    last_frame = mask.frame;
    EXPECT_EQ(mask.width_px, SyntheticRun::kWidth);
    EXPECT_EQ(mask.height_px, SyntheticRun::kHeight);
    EXPECT_FALSE(mask.rle.empty());
    has_large_id = has_large_id || (mask.track_id == 1234 && mask.class_id == 7);
  }
  EXPECT_TRUE(has_large_id);
}

TEST_F(RunReader, HasNoMasksWhereNoneWereWritten) {
  std::filesystem::remove(run_path() / "mots.txt");
  EXPECT_TRUE(read_masks(run_path()).value().empty());
}

TEST_F(RunReader, NumbersFramesAfterTheObjectsTimes) {
  // As if frames 5 and 6 had not been there.
  for (const char* name : {"camera.tum", "camera_kitti.txt"}) {
    edit(name, [](std::vector<std::string>& lines) { lines.erase(lines.begin() + 5, lines.begin() + 7); });
  }
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 4, 7, 8, 9, 10, 11));
}

TEST_F(RunReader, NumbersFramesWithoutObjectsByTheirTimes) {
  const auto is_early = [](const std::string& line) { return line.starts_with("0,") || line.starts_with("1,"); };
  edit("objects.csv", [&](std::vector<std::string>& lines) { std::erase_if(lines, is_early); });
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  edit("objects.csv", [](std::vector<std::string>& lines) { lines.resize(1); });
  for (const char* name : {"camera.tum", "camera_kitti.txt"}) {
    edit(name, [](std::vector<std::string>& lines) { lines.erase(lines.begin() + 4); });
  }
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11));
}

TEST_F(RunReader, NeedsAFinishedRun) {
  std::filesystem::remove(run_path() / "run.json");
  const Result<recording::Run> run = read_run(run_path());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(run.error().message, HasSubstr("run.json"));
}

TEST_F(RunReader, NamesFileAndLineOfAMistake) {
  edit("objects.csv", [](std::vector<std::string>& lines) { lines[3].replace(lines[3].find("car"), 3, "cat"); });
  EXPECT_THAT(error(), HasSubstr("objects.csv, line 4: 'cat' is no class"));
}

TEST_F(RunReader, RefusesADamagedStatusNumberOrOrder) {
  const std::vector<std::string> whole = read_lines(run_path() / "objects.csv");
  const auto error_of = [&](std::size_t line, const std::string& from, const std::string& to) {
    edit("objects.csv", [&](std::vector<std::string>& lines) {
      lines = whole;
      lines[line].replace(lines[line].find(from), from.size(), to);
    });
    return error();
  };
  EXPECT_THAT(error_of(1, "tracked", "racked"), HasSubstr("line 2: 'racked' is no status"));
  EXPECT_THAT(error_of(2, ",tracked,", ",tracked,x"), HasSubstr("line 3"));
  EXPECT_THAT(error_of(4, "2,", "0,"), HasSubstr("the frame number falls"));
  EXPECT_THAT(error_of(0, "status", "state"), HasSubstr("line 1: column 'status' is missing"));
}

TEST_F(RunReader, RefusesCameraFilesOfDifferentLength) {
  edit("camera_kitti.txt", [](std::vector<std::string>& lines) { lines.pop_back(); });
  EXPECT_THAT(error(), HasSubstr("camera_kitti.txt"));
  edit("camera_kitti.txt", [](std::vector<std::string>& lines) {
    lines.push_back(lines.back());
    lines.push_back(lines.back());
  });
  EXPECT_THAT(error(), HasSubstr("more rows than camera.tum"));
}

TEST_F(RunReader, RefusesADamagedRunJson) {
  std::ofstream(run_path() / "run.json") << "{\"dataset\": ";
  EXPECT_THAT(error(), HasSubstr("run.json"));
}

TEST_F(RunReader, RefusesMasksWithWrongIds) {
  std::ofstream(run_path() / "mots.txt") << "0 1001 1 4 4 abc\n0 999 1 4 4 abc\n";
  const Result<std::vector<MaskRow>> masks = read_masks(run_path());
  ASSERT_FALSE(masks);
  EXPECT_THAT(masks.error().message, HasSubstr("mots.txt, line 2: obj_id 999 does not fit class_id 1"));
}

}  // namespace
}  // namespace kinetrace::recording
