#include "kinetrace/recording/run_recorder.hpp"

#include <limits>
#include <sys/resource.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

std::string message_of(const RecordingConfig& config) {
  const Status valid = config.validate();
  return valid ? "valid" : valid.error().message;
}

TEST(RecordingConfig, NamesTheKeyThatIsOutOfRange) {
  RecordingConfig good = recording_config("/run");
  EXPECT_EQ(message_of(good), "valid");
  RecordingConfig config = good;
  config.max_objects = 65;
  EXPECT_EQ(message_of(config), "recording.max_objects must be in [1, 64], got 65");
  config = good;
  config.flush_interval_frames = 0;
  EXPECT_EQ(message_of(config), "recording.flush_interval_frames must be in [1, 100000], got 0");
  config = good;
  config.conversion_kib = 63;
  EXPECT_EQ(message_of(config), "recording.conversion_kib must be in [64, 262144], got 63");
  config = good;
  config.max_trajectory_vertices = 0;
  EXPECT_EQ(message_of(config), "recording.max_trajectory_vertices must be in [1, 1000000000], got 0");
  config = good;
  config.directory.clear();
  EXPECT_NE(message_of(config).find("recording.directory"), std::string::npos);
  config = good;
  config.geometry.fx_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message_of(config).find("recording.geometry"), std::string::npos);
}

TEST(RunRecorder, RefusesAnArenaThatIsTooSmallBeforeTouchingTheFolder) {
  const TemporaryFolder folder;
  const RecordingConfig config = recording_config(folder.path() / "run");
  Arena arena(RunRecorder::required_bytes(config) - 1);
  const Result<RunRecorder> recorder = RunRecorder::create(config, arena);
  ASSERT_FALSE(recorder);
  EXPECT_EQ(recorder.error().code, ErrorCode::kCapacity);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "run"));
}

TEST(RunRecorder, AFolderThatHasGoneIsNotWrittenIntoForNothing) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path() / "run"));
  ASSERT_TRUE(fixture.recorder);
  std::filesystem::remove_all(folder.path() / "run");
  const Status finished = fixture.recorder->finish({});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kIo);
  EXPECT_EQ(finished.error().message,
            (folder.path() / "run").string() +
                ": has gone while the run was writing into it; its results are lost, run again");
}

TEST(RunRecorder, ARunWithoutFramesIsComplete) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  ASSERT_TRUE(fixture.recorder->finish({}));
  EXPECT_TRUE(read_lines(folder.path() / "camera.tum").empty());
  EXPECT_TRUE(read_csv(folder.path() / "objects.csv").empty());
  EXPECT_TRUE(read_lines(folder.path() / "mots.txt").empty());
  EXPECT_TRUE(read_ply(folder.path() / "points/background.ply").vertices.empty());
  EXPECT_TRUE(nlohmann::json::parse(read_text(folder.path() / "run.json")).contains("frame_ms"));
}

TEST(RunRecorder, ARunWithoutObjectsHasACameraPath) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  ASSERT_TRUE(SyntheticRun({.frames = 1}).play(*fixture.recorder));
  ASSERT_TRUE(fixture.recorder->finish({}));
  EXPECT_EQ(read_tum(folder.path() / "camera.tum").size(), 1U);
  EXPECT_TRUE(read_csv(folder.path() / "objects.csv").empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "tracks"));
}

TEST(RunRecorder, RecordsAsManyObjectsAsConfiguredAndRefusesOneMore) {
  for (const int extra : {0, 1}) {
    const TemporaryFolder folder;
    RecordingConfig config = recording_config(folder.path());
    config.max_objects = 3;
    RecorderFixture fixture(config);
    ASSERT_TRUE(fixture.recorder);
    SyntheticRunConfig run{.frames = 6};
    for (int i = 0; i < config.max_objects + extra; ++i) {
      run.objects.push_back({.track_id = static_cast<std::uint32_t>(i + 1)});
    }
    const Status played = SyntheticRun(run).play(*fixture.recorder);
    ASSERT_EQ(played.has_value(), extra == 0);
    if (!played) {
      EXPECT_EQ(played.error().code, ErrorCode::kCapacity);
      EXPECT_EQ(played.error().message, "cannot record frame 0: 4 objects exceed recording.max_objects 3; raise it");
    }
  }
}

/// Tracks of a long run by far outnumber the files a process may have open.
TEST(RunRecorder, ThousandsOfTracksNeedFewOpenFiles) {
  const TemporaryFolder folder;
  RecordingConfig config = recording_config(folder.path());
  config.conversion_kib = 64;
  SyntheticRunConfig run{.frames = 600, .background_points = 4};
  for (int i = 0; i < 1200; ++i) {
    run.objects.push_back(
        {.track_id = static_cast<std::uint32_t>(i + 1), .first_frame = i / 2, .last_frame = i / 2 + 3, .points = 2});
  }
  rlimit previous{};
  ::getrlimit(RLIMIT_NOFILE, &previous);
  const rlimit limit{24, previous.rlim_max};
  RecorderFixture fixture(config);
  ASSERT_TRUE(fixture.recorder);
  ::setrlimit(RLIMIT_NOFILE, &limit);
  const Status played = SyntheticRun(run).play(*fixture.recorder);
  const Status finished = fixture.recorder->finish({});
  ::setrlimit(RLIMIT_NOFILE, &previous);
  ASSERT_TRUE(played) << played.error().message;
  ASSERT_TRUE(finished) << finished.error().message;
  EXPECT_EQ(read_tum(folder.path() / "tracks/1100.tum").size(), 4U);
  EXPECT_EQ(read_colmap(folder.path() / "colmap/object_1100").points.size(), 2U);
  EXPECT_EQ(read_csv(folder.path() / "objects.csv").size(), 4U * 1200U - 12U);  // The last six tracks are cut off.
}

TEST(RunRecorder, RefusesFramesOutOfOrder) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  FrameResult result;
  result.newest.frame_index = 5;
  ASSERT_TRUE(fixture.recorder->record(result));
  result.newest.frame_index = 4;
  const Status recorded = fixture.recorder->record(result);
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(recorded.error().message, "cannot record frame 4: frame 5 came before; record in ascending order");
}

TEST(RunRecorder, RefusesFramesThatFinaliseTwiceOrTooEarly) {
  for (const int finalised : {1, 3}) {
    const TemporaryFolder folder;
    RecorderFixture fixture(recording_config(folder.path()));
    ASSERT_TRUE(fixture.recorder);
    FrameResult result;
    result.has_finalised = true;
    result.newest.frame_index = 1;
    result.finalised.frame_index = 1;
    ASSERT_TRUE(fixture.recorder->record(result));
    result.newest.frame_index = 2;
    result.finalised.frame_index = finalised;
    const Status recorded = fixture.recorder->record(result);
    ASSERT_FALSE(recorded) << finalised;
    EXPECT_EQ(recorded.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(RunRecorder, RefusesFrameNumbersThatTheFormatsCannotHold) {
  for (const std::int64_t frame : {std::int64_t{-1}, std::int64_t{1} << 31}) {
    const TemporaryFolder folder;
    RecorderFixture fixture(recording_config(folder.path()));
    ASSERT_TRUE(fixture.recorder);
    FrameResult result;
    result.newest.frame_index = frame;
    EXPECT_FALSE(fixture.recorder->record(result)) << frame;
  }
}

TEST(RunRecorder, RefusesPosesThatAreNotFinite) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  ObjectResult object;
  object.track_id = 8;
  object.status = BodyStatus::kInitializing;
  object.T_world_obj.translation.x() = std::numeric_limits<double>::quiet_NaN();
  FrameResult result;
  result.has_finalised = true;
  result.finalised.objects = std::span(&object, 1);
  EXPECT_TRUE(fixture.recorder->record(result)) << "initializing objects have no pose yet";
  result.newest.frame_index = result.finalised.frame_index = 1;
  object.status = BodyStatus::kTracked;
  const Status recorded = fixture.recorder->record(result);
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().message, "cannot record frame 1: the pose of object 8 is not finite");
}

TEST(RunRecorder, LostObjectsKeepTheirRowButLeaveTheirTrack) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  ASSERT_TRUE(SyntheticRun({.frames = 4,
                            .objects = {{.track_id = 1, .status = BodyStatus::kLost},
                                        {.track_id = 2, .status = BodyStatus::kPropagated}}})
                  .play(*fixture.recorder));
  ASSERT_TRUE(fixture.recorder->finish({}));
  const auto rows = read_csv(folder.path() / "objects.csv");
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0].at("status"), "lost");
  EXPECT_EQ(rows[1].at("status"), "propagated");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "tracks/1.tum"));
  EXPECT_EQ(read_tum(folder.path() / "tracks/2.tum").size(), 4U);
}

TEST(RunRecorder, TextFilesAreOnDiskAfterEachFlushInterval) {
  const TemporaryFolder folder;
  RecordingConfig config = recording_config(folder.path());
  config.flush_interval_frames = 5;
  RecorderFixture fixture(config);
  ASSERT_TRUE(fixture.recorder);
  EXPECT_TRUE(read_csv(folder.path() / "objects.csv").empty()) << "the header is there at once";
  SyntheticRun run({.frames = 30, .settling_lag = 0});
  for (int i = 0; i < 9; ++i) {
    ASSERT_TRUE(fixture.recorder->record(*run.next()));
  }
  EXPECT_EQ(read_tum(folder.path() / "camera.tum").size(), 5U);
}

TEST(RunRecorder, TakesNothingAfterFinish) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  ASSERT_TRUE(fixture.recorder->finish({}));
  const Status recorded = fixture.recorder->record({});
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kIllegalState);
  const Status finished = fixture.recorder->finish({});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kIllegalState);
}

TEST(RunRecorder, SameRunSameBytes) {
  const TemporaryFolder folder;
  for (const char* name : {"a", "b"}) {
    RecorderFixture fixture(recording_config(folder.path() / name));
    ASSERT_TRUE(fixture.recorder);
    ASSERT_TRUE(SyntheticRun({.frames = 30, .objects = {{.track_id = 1}, {.track_id = 2}}}).play(*fixture.recorder));
    ASSERT_TRUE(fixture.recorder->finish({}));
  }
  int compared = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path() / "a")) {
    if (entry.is_regular_file()) {
      const auto relative = entry.path().lexically_relative(folder.path() / "a");
      EXPECT_EQ(read_text(entry.path()), read_text(folder.path() / "b" / relative)) << relative;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 25);
}

}  // namespace
}  // namespace kinetrace::recording
