// kinetrace evaluate, from outside: a run that equals the truth, and errors in files and conditions.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"
#include "truth_run.hpp"

namespace kinetrace::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace fs = std::filesystem;

class Evaluate : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    world_ = new TruthRun(shared_->path() / "sim");
  }
  static void TearDownTestSuite() {
    delete world_;
    delete shared_;
  }

  void SetUp() override { world_->record(run()); }
  [[nodiscard]] fs::path run() const { return scratch_.path() / "run"; }
  [[nodiscard]] ProgramResult evaluate(const fs::path& truth, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"evaluate", run().string(), "--truth", truth.string()});
    return run_kinetrace(more);
  }
  [[nodiscard]] json evaluation(const fs::path& truth, std::vector<std::string> more = {}) const {
    more.emplace_back("--json");
    const ProgramResult result = evaluate(truth, std::move(more));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  /// Replaces the run by what the program finds in the recording.
  void play_recording() const {
    const fs::path masks = world_->truth() / "masks";
    const ProgramResult played =
        run_kinetrace({"run", "--quiet", "--dataset", "kitti-raw:" + world_->recording().string(), "--segmentation",
                       "masks:" + (masks / "detections_left").string() + "," + (masks / "detections_right").string(),
                       "--out", run().string()});
    ASSERT_EQ(played.exit_code, 0) << played.err;
  }
  /// A copy of the truth that a test may damage.
  [[nodiscard]] fs::path copied_truth() const {
    fs::path copy = scratch_.path() / "truth";
    fs::copy(world_->truth(), copy, fs::copy_options::recursive);
    return copy;
  }

  static inline TempFolder* shared_ = nullptr;
  static inline TruthRun* world_ = nullptr;
  TempFolder scratch_;
};

/// The number at `path`, such as "/camera/t_rel"; not a number if it was not measured, so that no comparison holds.
double number(const json& found, const char* path) {
  const json::json_pointer pointer(path);
  const bool is_there = found.contains(pointer) && found.at(pointer).is_number();
  EXPECT_TRUE(is_there) << path;
  return is_there ? found.at(pointer).get<double>() : std::numeric_limits<double>::quiet_NaN();
}

void expect_no_error(const json& found) {
  for (const char* path :
       {"/camera/ate/first/max", "/camera/ate/se3/max", "/camera/rpe/rotation/max", "/objects/motion/translation/max",
        "/objects/motion/rotation/max", "/objects/distance/max", "/objects/center/max", "/objects/speed/max"}) {
    EXPECT_LT(number(found, path), 1e-5) << path;
  }
  for (const char* path :
       {"/objects/id_switches", "/objects/fragmentations", "/objects/false_moving", "/objects/motion/missing"}) {
    EXPECT_EQ(number(found, path), 0.0) << path;
  }
  EXPECT_EQ(number(found, "/objects/coverage"), 100.0);
  EXPECT_EQ(number(found, "/objects/moving_found"), 100.0);
}

TEST_F(Evaluate, FindsNoErrorInTheTruthItself) {
  const json found = evaluation(world_->truth(), {});
  expect_no_error(found);
  EXPECT_LT(number(found, "/camera/t_rel"), 1e-3);
  EXPECT_EQ(found["objects"]["association"], "masks");
  EXPECT_GT(number(found, "/objects/motion/pairs"), 0);
  EXPECT_NEAR(number(found, "/masks/hota"), 100.0, 1e-9);
  EXPECT_NEAR(number(found, "/masks/smotsa"), 100.0, 1e-9);
  std::ifstream file(run() / "evaluation.json");
  EXPECT_EQ(json::parse(file, nullptr, false), found);
}

TEST_F(Evaluate, AlignsARunThatStartsLater) {
  world_->record(run(), 3);
  const json found = evaluation(world_->truth());
  expect_no_error(found);
  EXPECT_EQ(found["camera"]["frames"], TruthRun::kFrames - 3);
}

TEST_F(Evaluate, FindsNoErrorByCentres) {
  const json found = evaluation(world_->truth(), {"--association", "centres"});
  expect_no_error(found);
  EXPECT_TRUE(found["masks"].is_null());
}

TEST_F(Evaluate, TakesLabelsWithCameraPoses) {
  const fs::path labels = world_->truth() / "label_02.txt";
  EXPECT_EQ(evaluate(labels).exit_code, 64);
  const fs::path poses = world_->truth() / "camera_poses.txt";
  const json found = evaluation(labels, {"--truth-camera", poses.string()});
  EXPECT_EQ(found["truth_format"], "kitti-tracking");
  EXPECT_EQ(found["objects"]["association"], "boxes");
  EXPECT_EQ(found["objects"]["id_switches"], 0);
  // Labels have no pitch; their speed comes from positions.
  EXPECT_LT(number(found, "/objects/motion/translation/mean"), 0.01);
  EXPECT_GT(number(found, "/objects/coverage"), 90.0);
  const json masked = evaluation(labels, {"--truth-camera", poses.string(), "--truth-masks",
                                          (world_->truth() / "masks" / "instances_left").string()});
  EXPECT_EQ(masked["objects"]["association"], "masks");
  EXPECT_EQ(number(masked, "/objects/coverage"), 100.0);
}

TEST_F(Evaluate, TakesPosesAlone) {
  const json found = evaluation(world_->truth() / "camera_poses.txt");
  EXPECT_EQ(found["truth_format"], "kitti-poses");
  EXPECT_LT(number(found, "/camera/ate/first/max"), 1e-5);
  EXPECT_TRUE(found["objects"].is_null());
  const json by_time = evaluation(run() / "camera.tum");
  EXPECT_EQ(by_time["truth_format"], "tum");
  EXPECT_EQ(by_time["camera"]["frames"], TruthRun::kFrames);
}

TEST_F(Evaluate, PrintsATable) {
  const ProgramResult result = evaluate(world_->truth());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("t_rel"), HasSubstr("coverage                     100.00  %"),
                                HasSubstr("false moving tracks               0"), HasSubstr("HOTA")));
  EXPECT_THAT(evaluate(world_->truth(), {"--quiet"}).out, IsEmpty());
  EXPECT_EQ(evaluate(world_->truth(), {"--quiet", "--json"}).out, text_of(run() / "evaluation.json"));
}

TEST_F(Evaluate, SaysThatTwoRunsAreOfDifferentFrames) {
  const fs::path other = scratch_.path() / "other";
  world_->record(other);
  const ProgramResult same = evaluate(world_->truth(), {"--against", other.string()});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(same.err, "");
  fs::remove_all(other);
  world_->record(other, 3);
  const ProgramResult different = evaluate(world_->truth(), {"--against", other.string()});
  EXPECT_EQ(different.exit_code, 0) << different.err;
  EXPECT_THAT(different.err, AllOf(HasSubstr("not of the same frames: 10 frames over "), HasSubstr(" m and 7 over ")));
}

void name_recording(const fs::path& run, const std::string& dataset, const std::string& sequence = "drive") {
  json about = json::parse(text_of(run / "run.json"));
  about["dataset"] = {{"dataset", dataset}, {"sequence", sequence}};
  std::ofstream(run / "run.json") << about.dump();
}

TEST_F(Evaluate, RefusesToCompareRunsOfDifferentRecordings) {
  const fs::path other = scratch_.path() / "other";
  world_->record(other);
  name_recording(run(), "kitti-raw:/data/town");
  name_recording(other, "kitti-raw:/data/village");
  const ProgramResult different = evaluate(world_->truth(), {"--against", other.string()});
  expect_refusal(different, kBadData, run().string() + " and " + other.string() + ": are of different recordings");
  EXPECT_THAT(different.err, HasSubstr("the recordings kitti-raw:/data/town and kitti-raw:/data/village"));
  EXPECT_FALSE(fs::exists(other / "evaluation.json"));
  for (const char* same : {"kitti-raw:/elsewhere/town", "kitti-raw:/data/town/drive"}) {
    name_recording(other, same);
    EXPECT_EQ(evaluate(world_->truth(), {"--against", other.string()}).exit_code, 0) << same;
  }
  name_recording(other, "kitti-raw:/data/town", "way back");
  expect_refusal(evaluate(world_->truth(), {"--against", other.string()}), kBadData,
                 "(the sequences drive and way back)");
}

TEST_F(Evaluate, RefusesToCompareRunsWithDifferentTimes) {
  const fs::path other = scratch_.path() / "other";
  world_->record(other);
  name_recording(run(), "kitti-raw:/data/town");
  EXPECT_EQ(evaluate(world_->truth(), {"--against", other.string()}).exit_code, 0) << "a run without a name";
  fs::remove_all(other);
  world_->record(other, 0, 3'600'000'000'000);
  const char* const reason = "(only 0 of 10 times of frames are in both)";
  expect_refusal(evaluate(world_->truth(), {"--against", other.string()}), kBadData, reason);
  name_recording(other, "kitti-raw:/data/town");
  expect_refusal(evaluate(world_->truth(), {"--against", other.string()}), kBadData, reason);
}

TEST_F(Evaluate, FailsIfAConditionHolds) {
  const ProgramResult holds = evaluate(world_->truth(), {"--quiet", "--fail-if", "camera.t_rel>1.0", "--fail-if",
                                                         "objects.coverage >= 99", "--fail-if", "camera.frames==10"});
  EXPECT_EQ(holds.exit_code, 1);
  EXPECT_EQ(holds.err,
            "kinetrace: error: objects.coverage >= 99: objects.coverage is 100\n"
            "kinetrace: error: camera.frames==10: camera.frames is 10\n");
  EXPECT_EQ(evaluate(world_->truth(), {"--quiet", "--fail-if", "objects.false_moving>0"}).exit_code, 0);
}

TEST_F(Evaluate, FailsIfAConditionCannotBeChecked) {
  const auto code = [&](const char* condition) {
    return evaluate(world_->truth() / "camera_poses.txt", {"--quiet", "--fail-if", condition}).exit_code;
  };
  EXPECT_EQ(code("camera.t_rel"), 64);
  EXPECT_EQ(code("camera.no_such_name>1"), 64);
  EXPECT_EQ(code("objects.coverage<95"), 65);  // This truth has no objects.
}

TEST_F(Evaluate, NamesTheFileThatIsMissingOrDamaged) {
  const ProgramResult missing = evaluate(scratch_.path() / "nothing");
  EXPECT_EQ(missing.exit_code, 66);
  EXPECT_THAT(missing.err, HasSubstr("nothing"));

  const fs::path truth = copied_truth();
  const fs::path image = truth / "masks" / "instances_left" / "0000000004.png";
  fs::resize_file(image, 50);
  const ProgramResult damaged = evaluate(truth);
  EXPECT_EQ(damaged.exit_code, 65);
  EXPECT_THAT(damaged.err, HasSubstr("0000000004.png"));
  fs::remove(image);
  EXPECT_THAT(evaluate(truth).err, HasSubstr("instances_left 9 mask images"));

  std::ofstream(truth / "camera_poses.txt") << "1 0 0 0\n";
  EXPECT_THAT(evaluate(truth).err, HasSubstr("camera_poses.txt, line 1"));
  for (const char* name : {"run.json", "camera.tum"}) {
    fs::remove(run() / name);
  }
  const ProgramResult no_run = evaluate(world_->truth());
  EXPECT_EQ(no_run.exit_code, 66);
  EXPECT_THAT(no_run.err, HasSubstr("run.json"));
}

TEST_F(Evaluate, TakesAFolderWhoseRunWasKilledAndSaysSo) {
  fs::remove(run() / "run.json");
  const ProgramResult result = evaluate(world_->truth(), {"--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("warning: " + run().string() + ": the run did not end in good order"));
  const json found = json::parse(result.out, nullptr, false);
  EXPECT_EQ(found["camera"]["frames"], TruthRun::kFrames);
  EXPECT_EQ(found["notes"].size(), 1U);
}

TEST_F(Evaluate, SaysThatARunHasNoFrame) {
  for (const char* file : {"camera.tum", "camera_kitti.txt"}) {
    fs::resize_file(run() / file, 0);
  }
  fs::remove(run() / "run.json");
  const ProgramResult result = evaluate(world_->truth());
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_THAT(result.err, HasSubstr(run().string() + ": the run has no frame"));
}

TEST_F(Evaluate, SaysWhichFramesHaveNoTruth) {
  const fs::path poses = scratch_.path() / "poses.txt";
  std::ifstream whole(world_->truth() / "camera_poses.txt");
  std::ofstream part(poses);
  std::string line;
  for (int i = 0; i < 6 && std::getline(whole, line); ++i) {
    part << line << '\n';
  }
  part.close();
  const ProgramResult result = evaluate(poses);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("a camera pose for 6 of the run's 10 frames"));
}

TEST_F(Evaluate, ReplacesItsFileAsAWhole) {
  ASSERT_EQ(evaluate(world_->truth(), {"--quiet"}).exit_code, 0);
  fs::permissions(run() / "evaluation.json", fs::perms::owner_read);
  EXPECT_EQ(evaluate(world_->truth(), {"--quiet"}).exit_code, 0);
  EXPECT_TRUE(std::none_of(fs::directory_iterator(run()), {},
                           [](const fs::directory_entry& entry) { return entry.path().extension() == ".tmp"; }));
}

TEST_F(Evaluate, RefusesMaskImagesOfAnotherSizeBeforeTheyTakeMemory) {
  const fs::path truth = copied_truth();
  forge_png_size(truth / "masks" / "instances_left" / "0000000004.png", 65535, 65535);
  const ProgramResult result = evaluate(truth);
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_THAT(result.err, HasSubstr("0000000004.png"));
}

TEST_F(Evaluate, RefusesWhatIsNoFileAndNamesIt) {
  const auto expect_refused = [&](const std::vector<std::string>& more, const fs::path& culprit) {
    const ProgramResult result = evaluate(world_->truth(), more);
    EXPECT_EQ(result.exit_code, 65);
    EXPECT_THAT(result.err, HasSubstr(culprit.string() + ": is a "));
    EXPECT_THAT(result.err, HasSubstr("not a file; give the path of a file"));
  };
  expect_refused({"--truth-body-camera", scratch_.path().string()}, scratch_.path());
  expect_refused({"--truth-body-camera", "/dev/zero"}, "/dev/zero");
  fs::remove(run() / "run.json");
  fs::create_directory(run() / "run.json");
  expect_refused({}, run() / "run.json");
}

TEST_F(Evaluate, RefusesTruthOfAnotherRecording) {
  const fs::path poses = scratch_.path() / "other.tum";
  std::ofstream(poses) << "12.5 0 0 0 0 0 0 1\n";
  const ProgramResult result = evaluate(poses);
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_THAT(result.err, HasSubstr("same recording"));
}

TEST_F(Evaluate, MeasuresARunOfTheRecording) {
  play_recording();
  EXPECT_THAT(evaluate(world_->truth()).err, IsEmpty());
  const json found = evaluation(world_->truth());
  EXPECT_EQ(found["camera"]["frames"], TruthRun::kFrames);
  EXPECT_GT(number(found, "/camera/ate/first/max"), 0.0);
  EXPECT_LT(number(found, "/camera/ate/first/max"), 0.5);
  EXPECT_GT(number(found, "/objects/matched_frames"), 0);
}

TEST_F(Evaluate, WarnsOfTruthBesideAnotherRecording) {
  play_recording();
  const fs::path other = scratch_.path() / "other";
  fs::create_directory(other);
  fs::copy(world_->truth(), other / "truth", fs::copy_options::recursive);
  EXPECT_THAT(evaluate(other).err, IsEmpty());  // Copied without its recording.
  fs::create_directory(other / "2026_01_01");
  std::ofstream(other / "2026_01_01" / "calib_cam_to_cam.txt") << "S_00: 1 1\n";
  for (const fs::path& truth : {other, other / "truth"}) {
    const ProgramResult result = evaluate(truth);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_THAT(result.err, HasSubstr(truth.string() + ": is the truth of " + other.string() + ", the run is of "));
  }
}

TEST_F(Evaluate, WarnsOfATruthThatGoesAnotherWay) {
  const fs::path other = scratch_.path() / "other.txt";
  std::ifstream poses(world_->truth() / "camera_poses.txt");
  std::ofstream longer(other);
  // Only the last column's third row, the way ahead, is longer.
  for (std::string line; std::getline(poses, line);) {
    const std::size_t last = line.rfind(' ') + 1;
    longer << line.substr(0, last) << 1.2 * std::stod(line.substr(last)) << '\n';
  }
  longer.close();
  const ProgramResult result = evaluate(other);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, AllOf(HasSubstr("differs from " + other.string()), HasSubstr("truth of another recording")));
  EXPECT_THAT(evaluate(world_->truth() / "camera_poses.txt").err, IsEmpty());
}

}  // namespace
}  // namespace kinetrace::test
