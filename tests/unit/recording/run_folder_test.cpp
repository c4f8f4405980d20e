// The folder itself: creation, removal of an earlier run, refusal, and full disks.
#include "run_folder.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "kinetrace/imaging/image_info.hpp"
#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

void touch(const fs::path& path) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << "x\n";
}

TEST(RunFolder, IsMadeWithItsParentsAndLeavesNoSpool) {
  const TemporaryFolder folder;
  const fs::path directory = folder.path() / "a/b/run";
  ASSERT_TRUE(record_all(recording_config(directory), {.objects = {{.track_id = 5}}}));
  for (const char* name :
       {"README.txt", "run.json", "camera.tum", "camera_kitti.txt", "camera_frames.csv", "objects.csv", "label_02.txt",
        "mots.txt", "tracks/5.tum", "points/object_5.ply", "colmap/object_5/cameras.txt"}) {
    EXPECT_TRUE(fs::is_regular_file(directory / name)) << name;
  }
  EXPECT_FALSE(fs::exists(directory / ".spool"));
  EXPECT_TRUE(std::none_of(fs::recursive_directory_iterator(directory), {},
                           [](const fs::directory_entry& entry) { return entry.path().extension() == ".tmp"; }));
}

TEST(RunFolder, EarlierRunsGiveWayAndOtherFilesStay) {
  const TemporaryFolder folder;
  const fs::path& directory = folder.path();
  ASSERT_TRUE(record_all(recording_config(directory), {.objects = {{.track_id = 99}}}));
  touch(directory / "evaluation.json");  // Of the earlier run.
  touch(directory / "figure.png");
  touch(directory / "run.json.4711.tmp");
  touch(directory / "map" / "trajectories.csv");
  touch(directory / "notes.md");
  touch(directory / "tracks/mine.tum");
  touch(directory / "points/object_99_mine.ply");
  touch(directory / "colmap/object_99/mine.txt");
  touch(directory / "mine/tracks/99.tum");
  ASSERT_TRUE(record_all(recording_config(directory), {.objects = {{.track_id = 7}}}));
  for (const char* gone : {"evaluation.json", "figure.png", "run.json.4711.tmp", "map", "tracks/99.tum",
                           "points/object_99.ply", "points/object_99_model.ply", "colmap/object_99/points3D.txt"}) {
    EXPECT_FALSE(fs::exists(directory / gone)) << gone;
  }
  for (const char* kept : {"notes.md", "tracks/mine.tum", "points/object_99_mine.ply", "colmap/object_99/mine.txt",
                           "mine/tracks/99.tum", "tracks/7.tum"}) {
    EXPECT_TRUE(fs::exists(directory / kept)) << kept;
  }
}

TEST(RunFolder, AnAbandonedRunIsReplaced) {
  const TemporaryFolder folder;
  {
    RecorderFixture abandoned(recording_config(folder.path()));
    ASSERT_TRUE(abandoned.recorder);
    SyntheticRun run({});
    ASSERT_TRUE(abandoned.recorder->record(*run.next()));
  }
  EXPECT_FALSE(fs::exists(folder.path() / "run.json"));
  EXPECT_TRUE(record_all(recording_config(folder.path()), {}));
  EXPECT_TRUE(fs::exists(folder.path() / "run.json"));
}

TEST(RunFolder, ASecondRunIsRefusedBeforeAnythingIsRemoved) {
  const TemporaryFolder folder;
  const RecorderFixture first(recording_config(folder.path() / "run"));
  ASSERT_TRUE(first.recorder);
  const std::string before = read_text(folder.path() / "run/objects.csv");
  const RecorderFixture second(recording_config(folder.path() / "run"));
  ASSERT_FALSE(second.recorder);
  EXPECT_EQ(second.recorder.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(second.recorder.error().message.find("another run writes into it"), std::string::npos);
  EXPECT_EQ(read_text(folder.path() / "run/objects.csv"), before);
  EXPECT_TRUE(fs::exists(folder.path() / "run/.spool/poses.bin"));
}

TEST(RunFolder, TheLockEndsWithTheProcessHoweverThatEnds) {
  const TemporaryFolder folder;
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const RecorderFixture recorder(recording_config(folder.path()));
    const char begun = recorder.recorder ? 'y' : 'n';
    [[maybe_unused]] const ssize_t reported = ::write(ready[1], &begun, 1);
    ::pause();
  }
  char begun = 'n';
  ASSERT_EQ(::read(ready[0], &begun, 1), 1);
  EXPECT_EQ(begun, 'y');
  EXPECT_FALSE(record_all(recording_config(folder.path()), {}));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(record_all(recording_config(folder.path()), {}));
}

TEST(RunFolder, ImagesAreThoseOfTheModelsAndGiveWayToTheNextRun) {
  const TemporaryFolder folder;
  RecordingConfig recording = recording_config(folder.path());
  recording.images = true;
  ASSERT_TRUE(record_all(recording, {.frames = 3, .name_prefix = "left_"}));
  for (int frame = 0; frame < 3; ++frame) {
    const fs::path image = folder.path() / "images" / ("left_" + std::to_string(frame) + "_rectified.png");
    const Result<imaging::ImageInfo> info = imaging::read_image_info(image.c_str());
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->width, SyntheticRun::kWidth);
    EXPECT_NE(read_text(folder.path() / "colmap/background/images.txt").find(image.filename().string()),
              std::string::npos);
  }
  ASSERT_TRUE(record_all(recording_config(folder.path()), {.frames = 3}));
  EXPECT_FALSE(fs::exists(folder.path() / "images"));
}

TEST(RunFolder, PartsThatAreSwitchedOffAreRemovedFromAnEarlierRun) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()), {}));
  RecordingConfig recording = recording_config(folder.path());
  recording.mots = recording.points = recording.colmap = false;
  ASSERT_TRUE(record_all(recording, {.objects = {{.track_id = 1}}}));
  EXPECT_FALSE(fs::exists(folder.path() / "mots.txt"));
  EXPECT_FALSE(fs::exists(folder.path() / "points"));
  EXPECT_FALSE(fs::exists(folder.path() / "colmap"));
  EXPECT_EQ(read_tum(folder.path() / "tracks/1.tum").size(), 12U);
  EXPECT_EQ(read_text(folder.path() / "README.txt").find("colmap"), std::string::npos);
}

TEST(RunFolder, EachPartWorksWithoutTheOthers) {
  for (const bool points : {true, false}) {
    const TemporaryFolder folder;
    RecordingConfig recording = recording_config(folder.path());
    recording.points = points;
    recording.colmap = !points;
    ASSERT_TRUE(record_all(recording, {.objects = {{.track_id = 1}}}));
    EXPECT_EQ(fs::exists(folder.path() / "points/object_1.ply"), points);
    EXPECT_EQ(fs::exists(folder.path() / "colmap/object_1/images.txt"), !points);
  }
}

TEST(RunFolder, ForeignFilesAreNeverTouched) {
  const TemporaryFolder folder;
  touch(folder.path() / "camera.tum");
  const Status recorded = record_all(recording_config(folder.path()), {});
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(recorded.error().message, "cannot record to " + folder.path().string() +
                                          ": it holds files that are not an earlier run; name an empty or new folder");
  EXPECT_EQ(read_text(folder.path() / "camera.tum"), "x\n");
}

TEST(RunFolder, IsCheckedWithoutAChange) {
  const TemporaryFolder folder;
  EXPECT_TRUE(RunRecorder::check_folder(folder.path() / "a" / "run"));
  EXPECT_FALSE(fs::exists(folder.path() / "a"));
  touch(folder.path() / "foreign" / "camera.tum");
  const Status foreign = RunRecorder::check_folder(folder.path() / "foreign");
  ASSERT_FALSE(foreign);
  EXPECT_EQ(foreign.error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(RunRecorder::check_folder(folder.path() / "foreign" / "camera.tum"));
  EXPECT_FALSE(RunRecorder::check_folder(folder.path() / "foreign" / "camera.tum" / "run"));
  const RecordingConfig config = recording_config(folder.path() / "run");
  ASSERT_TRUE(record_all(config, {}));
  EXPECT_TRUE(RunRecorder::check_folder(config.directory));
  EXPECT_TRUE(fs::exists(config.directory / "run.json"));
  const RecorderFixture busy(config);
  EXPECT_FALSE(RunRecorder::check_folder(config.directory));
}

TEST(RunFolder, AFileInItsPlaceIsRefused) {
  const TemporaryFolder folder;
  touch(folder.path() / "run");
  const Status recorded = record_all(recording_config(folder.path() / "run"), {});
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kInvalidArgument);
  const Status below = record_all(recording_config(folder.path() / "run/deeper"), {});
  ASSERT_FALSE(below);
  EXPECT_EQ(below.error().code, ErrorCode::kIo);
}

TEST(RunFolder, ALinkToNothingIsRefused) {
  const TemporaryFolder folder;
  fs::create_symlink(folder.path() / "missing", folder.path() / "link");
  fs::create_symlink(folder.path() / "loop", folder.path() / "loop");
  for (const char* name : {"link", "loop"}) {
    const fs::path directory = folder.path() / name;
    for (const Status& refused : {record_all(recording_config(directory), {}), RunRecorder::check_folder(directory)}) {
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
      EXPECT_EQ(refused.error().message,
                "cannot record to " + directory.string() +
                    ": it is a link to a folder that does not exist; create that, or name another one");
    }
  }
}

/// Calls `work` without the right to write into `folder`. Root may write anywhere, so its privileges are dropped.
template <typename Work>
Status without_permission(const fs::path& folder, Work&& work) {
  fs::permissions(folder,
                  fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
  constexpr uid_t kNobody = 65534;
  const bool root = ::geteuid() == 0;
  EXPECT_TRUE(!root || ::setresuid(kNobody, kNobody, 0) == 0);
  Status done = work();
  EXPECT_TRUE(!root || ::setresuid(0, 0, 0) == 0);
  fs::permissions(folder, fs::perms::owner_all);
  return done;
}

TEST(RunFolder, IsCheckedForTheRightToWrite) {
  const TemporaryFolder folder;
  for (const fs::path& directory : {folder.path(), folder.path() / "run", folder.path() / "a" / "run"}) {
    const Status usable = without_permission(folder.path(), [&] { return RunRecorder::check_folder(directory); });
    ASSERT_FALSE(usable) << directory;
    EXPECT_EQ(usable.error().code, ErrorCode::kIo);
    EXPECT_NE(usable.error().message.find(folder.path().string()), std::string::npos) << usable.error().message;
    EXPECT_TRUE(RunRecorder::check_folder(directory));
  }
}

TEST(RunFolder, AnUnwritableParentIsNamed) {
  const TemporaryFolder folder;
  const Status recorded =
      without_permission(folder.path(), [&] { return record_all(recording_config(folder.path() / "run"), {}); });
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kIo);
  EXPECT_NE(recorded.error().message.find(folder.path().string()), std::string::npos);
  EXPECT_NE(recorded.error().message.find("make the folder writable"), std::string::npos) << recorded.error().message;
}

/// Makes files larger than `bytes` impossible, which looks like a disk that fills up.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : previous_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &previous_);
    const rlimit limit{bytes, previous_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &previous_);
    std::signal(SIGXFSZ, previous_handler_);
  }

 private:
  rlimit previous_{};
  void (*previous_handler_)(int);
};

TEST(RunFolder, AFullDiskStopsTheRecorderForGood) {
  const TemporaryFolder folder;
  RecordingConfig recording = recording_config(folder.path());
  recording.conversion_kib = 64;
  RecorderFixture fixture(recording);
  ASSERT_TRUE(fixture.recorder);
  const FileSizeLimit limit(20'000);
  const Status recorded = SyntheticRun({.frames = 200, .background_points = 50}).play(*fixture.recorder);
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kIo);
  EXPECT_NE(recorded.error().message.find("observations.bin"), std::string::npos) << recorded.error().message;
  SyntheticRun again({});
  const Status later = fixture.recorder->record(*again.next());
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().message, recorded.error().message);
  const Status finished = fixture.recorder->finish({});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, recorded.error().message);
  EXPECT_FALSE(fs::exists(folder.path() / "run.json"));
}

/// Whichever file no longer fits, `finish` reports it and leaves no run.json.
TEST(RunFolder, AFullDiskAtTheEndIsReported) {
  const SyntheticRunConfig run{.frames = 60, .background_points = 40};
  const TemporaryFolder whole;
  ASSERT_TRUE(record_all(recording_config(whole.path()), run));
  for (const char* name : {"README.txt", "run.json", "points/background.ply", "colmap/background/points3D.txt",
                           "colmap/background/images.txt"}) {
    const TemporaryFolder folder;
    RecorderFixture fixture(recording_config(folder.path()));
    ASSERT_TRUE(fixture.recorder);
    ASSERT_TRUE(SyntheticRun(run).play(*fixture.recorder));
    const FileSizeLimit limit(fs::file_size(whole.path() / name) - 1);
    const Status finished = fixture.recorder->finish({});
    ASSERT_FALSE(finished) << name;
    EXPECT_EQ(finished.error().code, ErrorCode::kIo);
    EXPECT_NE(finished.error().message.find(folder.path().string()), std::string::npos) << finished.error().message;
    EXPECT_FALSE(fs::exists(folder.path() / "run.json"));
  }
}

}  // namespace
}  // namespace kinetrace::recording
