#include "kinetrace/recording/run_reader.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

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
    summary.rig.emplace().applied = kApplied;
    ASSERT_TRUE(fixture.recorder->finish(summary));
  }
  [[nodiscard]] std::filesystem::path run_path() const { return folder_.path() / "run"; }
  /// Applies `change` to the lines of a file.
  void edit(const char* name, const std::function<void(std::vector<std::string>&)>& change) const {
    std::vector<std::string> lines = read_lines(run_path() / name);
    change(lines);
    std::ofstream file(run_path() / name);
    for (const std::string& line : lines) {
      file << line << '\n';
    }
  }
  /// As if the run had been killed.
  void end_early() const { std::filesystem::remove(run_path() / "run.json"); }
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
  const RigCorrection kApplied{{0.001, -0.002, 0.003}, {0.01, -0.02}, 0.0005, 0.0};
  TemporaryFolder folder_;
};

TEST_F(RunReader, GivesBackWhatWasRecorded) {
  const Result<recording::Run> run = read_run(run_path());
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_EQ(run->dataset, "folder:somewhere");
  EXPECT_EQ(run->sequence, "07");
  EXPECT_EQ(run->config_json, R"({"output":{"mots":true}})");
  EXPECT_TRUE(run->is_finished);
  EXPECT_THAT(run->notes, IsEmpty());
  EXPECT_EQ(run->rectified.width_px, SyntheticRun::kWidth);
  EXPECT_LT((run->applied.vector() - kApplied.vector()).norm(), 1e-12);
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
  const Result<std::vector<MaskRow>> masks = read_masks({.directory = run_path()});
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
  EXPECT_TRUE(read_masks({.directory = run_path()}).value().empty());
}

TEST_F(RunReader, GivesTheFrameNumbersOfTheSource) {
  // The recording begins with frame 101, and frames are missing without a longer step of time.
  end_early();
  edit("objects.csv", [](std::vector<std::string>& lines) { lines.resize(1); });
  edit("camera_frames.csv", [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i) {
      lines[i] = std::to_string(100 + i * i) + lines[i].substr(lines[i].find(','));
    }
  });
  EXPECT_THAT(camera_frames(), ElementsAre(101, 104, 109, 116, 125, 136, 149, 164, 181, 200, 221, 244));
}

TEST_F(RunReader, NumbersFramesAfterTheObjectsTimesInRunsOfEarlierVersions) {
  // As if frames 5 and 6 were missing.
  end_early();
  std::filesystem::remove(run_path() / "camera_frames.csv");
  const auto is_left_out = [](const std::string& line) { return line.starts_with("5,") || line.starts_with("6,"); };
  edit("objects.csv", [&](std::vector<std::string>& lines) { std::erase_if(lines, is_left_out); });
  for (const char* name : {"camera.tum", "camera_kitti.txt"}) {
    edit(name, [](std::vector<std::string>& lines) { lines.erase(lines.begin() + 5, lines.begin() + 7); });
  }
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 4, 7, 8, 9, 10, 11));
}

TEST_F(RunReader, NumbersFramesWithoutObjectsByTheirTimesInRunsOfEarlierVersions) {
  end_early();
  std::filesystem::remove(run_path() / "camera_frames.csv");
  const auto is_early = [](const std::string& line) { return line.starts_with("0,") || line.starts_with("1,"); };
  edit("objects.csv", [&](std::vector<std::string>& lines) { std::erase_if(lines, is_early); });
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  edit("objects.csv", [](std::vector<std::string>& lines) { lines.resize(1); });
  for (const char* name : {"camera.tum", "camera_kitti.txt"}) {
    edit(name, [](std::vector<std::string>& lines) { lines.erase(lines.begin() + 4); });
  }
  EXPECT_THAT(camera_frames(), ElementsAre(0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11));
}

TEST_F(RunReader, AFolderWithoutARunIsNotFound) {
  const Result<recording::Run> run = read_run(folder_.path());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(run.error().message, HasSubstr("run.json"));
}

TEST_F(RunReader, TakesWhatARunThatWasKilledLeftBehind) {
  end_early();
  // Killed while it wrote a row: the poses are one ahead, and cut.
  edit("camera.tum", [](std::vector<std::string>& lines) { lines.resize(7); });
  edit("camera_kitti.txt", [](std::vector<std::string>& lines) { lines.resize(8); });
  std::ofstream(run_path() / "camera_kitti.txt", std::ios::app) << "1 0 0";
  std::ofstream(run_path() / "objects.csv", std::ios::app) << "11,17000";
  const Result<recording::Run> run = read_run(run_path());
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_FALSE(run->is_finished);
  EXPECT_THAT(run->notes, ElementsAre(HasSubstr("did not end in good order")));
  EXPECT_THAT(run->camera, SizeIs(7));
  for (const ObjectRow& row : run->objects) {
    EXPECT_LE(row.frame, 6);
  }
  EXPECT_THAT(run->objects, SizeIs(7 + 4 + 4));
  std::ofstream(run_path() / "mots.txt", std::ios::app) << "11 1001 1 1";
  EXPECT_TRUE(read_masks(*run));
}

TEST_F(RunReader, ReadsARunInProgressAndSaysSo) {
  RecorderFixture fixture(recording_config(folder_.path() / "live"));
  ASSERT_TRUE(fixture.recorder) << fixture.recorder.error().message;
  RunSummary begun;
  begun.dataset = {{"dataset", "folder:there"}};
  ASSERT_TRUE(fixture.recorder->begin(begun));
  SyntheticRun live({.settling_lag = 0});
  for (int frame = 0; frame < 5; ++frame) {
    ASSERT_TRUE(fixture.recorder->record(*live.next()));
  }
  const Result<recording::Run> run = read_run(folder_.path() / "live");
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_THAT(run->notes, ElementsAre(HasSubstr("a run is still writing")));
  EXPECT_EQ(run->dataset, "folder:there");
  EXPECT_EQ(run->rectified.height_px, SyntheticRun::kHeight);
  EXPECT_THAT(run->camera, SizeIs(5));
}

TEST_F(RunReader, KeepsNewRunsOutWhileItReads) {
  {
    const Result<recording::Run> run = read_run(run_path());
    ASSERT_TRUE(run) << run.error().message;
    EXPECT_TRUE(read_run(run_path())) << "readers do not mind each other";
    const RecorderFixture fixture(recording_config(run_path()));
    ASSERT_FALSE(fixture.recorder);
    EXPECT_THAT(fixture.recorder.error().message, HasSubstr("reads it"));
  }
  EXPECT_TRUE(RecorderFixture(recording_config(run_path())).recorder);
}

/// Any missing, duplicated or truncated file of a finished folder is detected.
TEST_F(RunReader, RefusesFilesThatDoNotFitEachOther) {
  const auto error_after = [&](const char* name, const std::function<void(std::vector<std::string>&)>& change) {
    const std::vector<std::string> whole = read_lines(run_path() / name);
    edit(name, change);
    std::string found = error();
    edit(name, [&](std::vector<std::string>& lines) { lines = whole; });
    return found;
  };
  using Lines = std::vector<std::string>;
  const auto drop_third = [](Lines& lines) { lines.erase(lines.begin() + 2); };
  const auto double_third = [](Lines& lines) { lines.insert(lines.begin() + 2, lines[2]); };
  EXPECT_THAT(error_after("camera_kitti.txt", [](Lines& lines) { std::reverse(lines.begin(), lines.end()); }),
              HasSubstr("camera_kitti.txt, line 1: the pose is not that of the same row of camera.tum"));
  EXPECT_THAT(error_after("camera_kitti.txt", [](Lines& lines) { lines.back().resize(lines.back().size() - 6); }),
              HasSubstr("camera_kitti.txt, line 12: the pose is not that of the same row"));
  EXPECT_THAT(error_after("camera_frames.csv", [](Lines& lines) { lines[2] = lines[1]; }),
              HasSubstr("camera_frames.csv, line 3: the time is not that of the same row of camera.tum"));
  EXPECT_THAT(error_after("camera_frames.csv", [](Lines& lines) { lines[3].replace(0, 1, "1"); }),
              HasSubstr("camera_frames.csv, line 4: the frame number does not grow"));
  EXPECT_THAT(error_after("camera_frames.csv", [](Lines& lines) { lines[1].replace(0, 1, "-4"); }),
              HasSubstr("camera_frames.csv, line 2: the frame number does not grow"));
  EXPECT_THAT(error_after("camera_frames.csv", [](Lines& lines) { lines[12].replace(0, 2, "12"); }),
              HasSubstr("the frame at this time has number 12 in camera_frames.csv"));
  EXPECT_THAT(error_after("camera_frames.csv", [](Lines& lines) { lines.pop_back(); }),
              HasSubstr("camera_frames.csv, line 12: the file ends after 11 rows, run.json tells of 12"));
  EXPECT_THAT(error_after("camera.tum", double_third), HasSubstr("camera.tum, line 4: the time does not grow"));
  EXPECT_THAT(error_after("camera.tum", [](Lines& lines) { lines[1] += " 1"; }),
              HasSubstr("camera.tum, line 2: expected 8 fields, found 9"));
  EXPECT_THAT(error_after("objects.csv", drop_third), HasSubstr("objects.csv, line 21: the file ends after 20 rows"));
  EXPECT_THAT(error_after("objects.csv", double_third), HasSubstr("objects.csv, line 4: frame 1 has track 1 twice"));
  EXPECT_THAT(error_after("label_02.txt", [](Lines& lines) { lines.clear(); }),
              HasSubstr("label_02.txt, line 0: the file ends after 0 rows"));
  EXPECT_THAT(error_after("run.json",
                          [](Lines& lines) {
                            for (std::string& line : lines) {
                              if (line.starts_with("  \"frames\": 12")) {
                                line = "  \"frames\": 40,";
                              }
                            }
                          }),
              HasSubstr("camera.tum, line 12: the file ends after 12 rows, run.json tells of 40"));
  for (const char* name : {"camera.tum", "camera_kitti.txt"}) {
    edit(name, drop_third);
  }
  EXPECT_THAT(error(), HasSubstr("camera.tum, line 11: the file ends after 11 rows, run.json tells of 12"));
  edit("run.json", [](Lines& lines) {
    for (std::string& line : lines) {
      line = line.starts_with("  \"frames\": 12") ? "  \"frames\": 11," : line;
    }
  });
  edit("camera_frames.csv", [](Lines& lines) { lines.erase(lines.begin() + 3); });
  EXPECT_THAT(error(), HasSubstr("objects.csv, line 4: camera.tum has no frame at this time"));
}

TEST_F(RunReader, RefusesAFileWhoseLastRowIsCut) {
  for (const char* name : {"camera.tum", "camera_kitti.txt", "camera_frames.csv", "objects.csv", "label_02.txt"}) {
    const std::filesystem::path file = run_path() / name;
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
    EXPECT_THAT(error(), HasSubstr("the last row is cut off")) << name;
    std::ofstream(file, std::ios::app) << '\n';
  }
  EXPECT_TRUE(read_run(run_path()));
}

TEST_F(RunReader, RefusesMasksThatAreNotTheRuns) {
  const Result<recording::Run> run = read_run(run_path());
  ASSERT_TRUE(run) << run.error().message;
  const std::vector<std::string> whole = read_lines(run_path() / "mots.txt");
  const auto masks_error = [&](const std::string& text) {
    std::ofstream(run_path() / "mots.txt") << text;
    const Result<std::vector<MaskRow>> masks = read_masks(*run);
    EXPECT_FALSE(masks) << text;
    return masks ? "" : masks.error().message;
  };
  EXPECT_THAT(masks_error(""), HasSubstr("mots.txt, line 0: the file ends after 0 rows"));
  EXPECT_THAT(masks_error(whole[0] + " 7\n"), HasSubstr("mots.txt, line 1: expected 6 fields, found 7"));
  EXPECT_THAT(masks_error("0 1001 1 65536 65536 :d0Rooooo3\n"),
              HasSubstr("65536 x 65536 pixels, the run's have 320 x 120"));
  std::filesystem::remove(run_path() / "mots.txt");
  EXPECT_FALSE(read_masks(*run));
}

TEST_F(RunReader, RefusesMasksOfAbsurdSizeWhereTheRunsIsNotKnown) {
  std::ofstream(run_path() / "mots.txt") << "0 1001 1 8193 8 :d0Rooooo3\n";
  const Result<std::vector<MaskRow>> masks = read_masks({.directory = run_path()});
  ASSERT_FALSE(masks);
  EXPECT_THAT(masks.error().message, HasSubstr("8 x 8193 pixels"));
}

TEST_F(RunReader, RefusesARunJsonThatIsNestedTooDeep) {
  for (const std::string& level : {std::string("["), std::string("{\"a\":")}) {
    std::string text = R"({"dataset":{},"frames":12,"config":{"a":)";
    for (int i = 0; i < 100'000; ++i) {
      text += level;
    }
    std::ofstream(run_path() / "run.json") << text;
    EXPECT_THAT(error(), HasSubstr("run.json: is nested more than 64 deep"));
  }
}

TEST_F(RunReader, RefusesWhatIsNoFile) {
  for (const char* name : {"run.json", "camera.tum", "objects.csv"}) {
    const std::filesystem::path file = run_path() / name;
    const std::string content = read_text(file);
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    EXPECT_THAT(error(), HasSubstr(file.string() + ": is a "));
    std::filesystem::remove(file);
    ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
    EXPECT_THAT(error(), HasSubstr(file.string() + ": is a "));
    std::filesystem::remove(file);
    std::ofstream(file) << content;
  }
  EXPECT_TRUE(read_run(run_path()));
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
  EXPECT_THAT(error_of(1, "0,", "2147483648,"), HasSubstr("line 2: 2147483648 is out of range"));
  EXPECT_THAT(error_of(0, "status", "state"), HasSubstr("line 1: column 'status' is missing"));
}

TEST_F(RunReader, RefusesCameraFilesOfDifferentLength) {
  std::string last;
  edit("camera_kitti.txt", [&](std::vector<std::string>& lines) {
    last = lines.back();
    lines.pop_back();
  });
  EXPECT_THAT(error(), HasSubstr("camera_kitti.txt"));
  edit("camera_kitti.txt", [&](std::vector<std::string>& lines) { lines.insert(lines.end(), {last, last}); });
  EXPECT_THAT(error(), HasSubstr("more rows than camera.tum"));
}

TEST_F(RunReader, RefusesADamagedRunJson) {
  std::ofstream(run_path() / "run.json") << "{\"dataset\": ";
  EXPECT_THAT(error(), HasSubstr("run.json"));
  for (const char* frames : {"1e180", "12.0", "\"12\"", "null"}) {
    std::ofstream(run_path() / "run.json") << R"({"dataset": {}, "config": {}, "frames": )" << frames << "}";
    EXPECT_THAT(error(), HasSubstr("run.json: is not the run.json of a run")) << frames;
  }
}

TEST_F(RunReader, RefusesMasksWithWrongIds) {
  for (const auto& [ids, what] : std::vector<std::pair<std::string, std::string>>{
           {"999 1", "obj_id 999 does not fit class_id 1"},
           {"16655 6553621474836475536", "obj_id 16655 does not fit class_id 6553621474836475536"},
           {"-9223372036854775808 1", "obj_id -9223372036854775808 does not fit class_id 1"}}) {
    std::ofstream(run_path() / "mots.txt") << "0 1001 1 4 4 abc\n0 " << ids << " 4 4 abc\n";
    const Result<std::vector<MaskRow>> masks = read_masks({.directory = run_path()});
    ASSERT_FALSE(masks);
    EXPECT_THAT(masks.error().message, HasSubstr("mots.txt, line 2: " + what));
  }
}

}  // namespace
}  // namespace kinetrace::recording
