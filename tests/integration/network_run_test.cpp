// Runs with a neural network, from outside.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class NetworkRun : public ::testing::Test {
 protected:
  void SetUp() override { recording_.write(); }
  /// The YAML file of a network that detects bright regions, see tests/unit/neural/make_models.
  [[nodiscard]] std::string model(const std::string& network = "yolov8-seg.onnx") const {
    const fs::path file = scratch_.path() / "model.yaml";
    std::ofstream(file) << "family: yolov8-seg\nmodel: " << KINETRACE_MODELS << "/" << network
                        << "\ninput: {width: 128, height: 64}\nclasses: [white, red]\n"
                           "use: {white: vehicle, red: person}\nthresholds: {score: 0.5, overlap: 0.45}\n";
    return file.string();
  }
  [[nodiscard]] std::vector<std::string> command(const char* name, const std::vector<std::string>& settings,
                                                 int loop = 1, const std::string& mode = "onnx") const {
    std::vector<std::string> all{"run",
                                 "--dataset",
                                 recording_.dataset(),
                                 "--out",
                                 out(name).string(),
                                 "--quiet",
                                 "--segmentation",
                                 mode + ":" + model(),
                                 "--loop",
                                 std::to_string(loop),
                                 "--set",
                                 "memory.budget_mib=256"};
    for (const std::string& setting : settings) {
      all.insert(all.end(), {"--set", setting});
    }
    return all;
  }
  /// Runs the program at `program`, or the one under test.
  [[nodiscard]] ProgramResult run_auto(const std::string& mode, const std::vector<std::string>& more,
                                       const std::string& program = KINETRACE_PROGRAM) const {
    std::vector<std::string> all{
        program,          "run", "--dataset", recording_.dataset(), "--out", out("auto").string(), "--quiet",
        "--segmentation", mode};
    all.insert(all.end(), more.begin(), more.end());
    const std::string printed = (scratch_.path() / "printed").string();
    const std::string err = (scratch_.path() / "err").string();
    const int exit_code = await_end(start_program(all, printed, err));
    return {exit_code, text_of(printed), text_of(err)};
  }
  [[nodiscard]] fs::path out(const char* name) const { return scratch_.path() / name; }
  [[nodiscard]] json report(const char* name) const {
    return json::parse(text_of(out(name) / "run.json"), nullptr, false);
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
};

TEST_F(NetworkRun, ARecordingGivesTheSameEveryTime) {
  for (const char* latency : {"0", "1", "3"}) {
    const std::string setting = std::string("segmentation.onnx.latency_frames=") + latency;
    for (const char* name : {"first", "second"}) {
      const ProgramResult result = run_kinetrace(command(name, {setting}, 3));
      ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    for (const char* file : {"camera.tum", "objects.csv", "mots.txt"}) {
      EXPECT_EQ(text_of(out("first") / file), text_of(out("second") / file)) << file << " with latency " << latency;
    }
    EXPECT_GT(report("first")["counters"]["detections"], 0) << latency;
    EXPECT_EQ(report("first")["counters"]["detection_frames_missing"], 0) << latency;
    EXPECT_EQ(report("first")["health"]["worst"], "ok") << latency;
    EXPECT_EQ(report("first")["allocations_after_start"], 0) << latency;
  }
}

TEST_F(NetworkRun, RegionsBetweenWholeImagesGiveTheSameEveryTimeToo) {
  for (const char* name : {"first", "second"}) {
    const ProgramResult result = run_kinetrace(command(name, {"segmentation.onnx.regions=2"}, 3));
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  EXPECT_EQ(text_of(out("first") / "objects.csv"), text_of(out("second") / "objects.csv"));
  EXPECT_EQ(report("first")["counters"]["detection_frames_missing"], 0);
  EXPECT_EQ(report("first")["health"]["worst"], "ok");
  EXPECT_EQ(report("first")["allocations_after_start"], 0);
}

TEST_F(NetworkRun, ItsMemoryIsInThePlanAndInTheBudget) {
  std::vector<std::string> small = command("out", {});
  small.insert(small.end(), {"--set", "memory.budget_mib=30"});
  const ProgramResult refused = run_kinetrace(small);
  EXPECT_EQ(refused.exit_code, 78);
  EXPECT_THAT(refused.err, HasSubstr("memory.budget_mib"));
  const ProgramResult plan = run_kinetrace({"plan", "--set", "segmentation.mode=onnx", "--set",
                                            "segmentation.onnx.model=" + model(), "--set", "memory.budget_mib=256"});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_THAT(plan.out, HasSubstr("neural network"));
}

TEST_F(NetworkRun, WhatIsWrongWithAModelIsSaidInOneLineAtTheStart) {
  const auto refused = [&](const std::string& yaml) {
    return run_kinetrace(
        {"run", "--dataset", recording_.dataset(), "--out", out("out").string(), "--segmentation", "onnx:" + yaml});
  };
  EXPECT_EQ(refused("/nowhere/model.yaml").exit_code, 66);
  EXPECT_EQ(refused(model("nowhere.onnx")).exit_code, 66);
  EXPECT_EQ(refused(model("not-a-model.onnx")).exit_code, 65);
  EXPECT_EQ(refused(model("nan-weights.onnx")).exit_code, 65);
  EXPECT_EQ(refused(model("huge-classes.onnx")).exit_code, 78);
  EXPECT_EQ(refused(std::string(KINETRACE_MODELS) + "/yolov8-seg.onnx").exit_code, 78);
  const ProgramResult operators = refused(model("rejected-operator.onnx"));
  EXPECT_EQ(operators.exit_code, 65);
  EXPECT_EQ(std::count(operators.err.begin(), operators.err.end(), '\n'), 1) << operators.err;
  EXPECT_FALSE(fs::exists(out("out"))) << "nothing was begun";
}

TEST_F(NetworkRun, AutoIsMotionAndANetworkTogetherAndGivesTheSameEveryTime) {
  for (const char* name : {"first", "second"}) {
    const ProgramResult result = run_kinetrace(command(name, {}, 3, "auto"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
  }
  EXPECT_EQ(text_of(out("first") / "objects.csv"), text_of(out("second") / "objects.csv"));
  EXPECT_EQ(text_of(out("first") / "mots.txt"), text_of(out("second") / "mots.txt"));
  const json run = report("first");
  EXPECT_EQ(run["config"]["segmentation"]["mode"], "auto");
  EXPECT_GT(run["counters"]["network_frames"], 0);
  EXPECT_GT(run["counters"]["detections"], 0);
  EXPECT_EQ(run["counters"]["detection_frames_missing"], 0);
  EXPECT_EQ(run["health"]["worst"], "ok");
  EXPECT_EQ(run["allocations_after_start"], 0);
}

TEST_F(NetworkRun, AutoIsMotionAloneWhereTheBudgetHasNoRoomForANetwork) {
  // Memory that motion segmentation needs, from the refusal of a budget of 1 MiB.
  const ProgramResult refused = run_auto("motion", {"--set", "memory.budget_mib=1"});
  std::smatch enough;
  ASSERT_TRUE(std::regex_search(refused.err, enough, std::regex("raise it to ([0-9.]+) MiB"))) << refused.err;
  for (const std::string& mode : {std::string("auto"), "auto:" + model()}) {
    const ProgramResult result = run_auto(mode, {"--set", "memory.budget_mib=" + enough[1].str()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("by their motion alone"));
    EXPECT_THAT(result.err, HasSubstr("too small"));
    EXPECT_EQ(report("auto")["config"]["segmentation"]["mode"], "motion");
    EXPECT_LE(report("auto")["rss_peak_bytes"], report("auto")["budget_bytes"]) << "none was loaded";
  }
  EXPECT_EQ(run_auto("auto", {"--set", "memory.budget_mib=1"}).exit_code, 78) << "nor for motion";
}

// A copy of the program without the files beside it.
TEST_F(NetworkRun, AutoIsMotionAloneWhereNoNetworkComesWithTheProgram) {
  const fs::path program = scratch_.path() / "kinetrace";
  fs::copy_file(KINETRACE_PROGRAM, program);
  const ProgramResult result = run_auto("auto", {}, program.string());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("by their motion alone"));
  EXPECT_THAT(result.err, HasSubstr("kinetrace-networks"));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_EQ(report("auto")["config"]["segmentation"]["mode"], "motion");
  EXPECT_EQ(report("auto")["warnings"].size(), 1U);
  EXPECT_NE(run_auto("auto:" + model(), {}, program.string()).exit_code, 0) << "this one was asked for";
}

TEST_F(NetworkRun, AutoRefusesAModelThatWasNamedAndCannotBeUsed) {
  EXPECT_EQ(run_auto("auto:/nowhere/model.yaml", {}).exit_code, 66);
  EXPECT_EQ(run_auto("auto:" + model("nan-weights.onnx"), {}).exit_code, 65);
}

TEST_F(NetworkRun, AutoSaysThatANetworkKnowsRenderedPicturesOnly) {
  const std::string yaml = model();
  std::ofstream(yaml, std::ios::app) << "trained_on: rendered\n";
  const ProgramResult result = run_auto("auto:" + yaml, {});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("was trained on rendered pictures alone"));
}

// A copy of the program with a plugin that never answers after the start.
TEST_F(NetworkRun, ANetworkThatHangsDegradesHealthAndTrackingContinues) {
#ifdef KINETRACE_EMULATED
  GTEST_SKIP() << "emulated, it is too slow to follow what plays like a camera";
#endif
  const fs::path program = scratch_.path() / "kinetrace";
  fs::copy_file(KINETRACE_PROGRAM, program);
  fs::copy_file(KINETRACE_HANGING_RUNTIME, scratch_.path() / "kinetrace-opencv-dnn.so");
  for (const char* mode : {"onnx", "auto"}) {
    // Live mode plays like a camera, which does not wait.
    std::vector<std::string> all = command("out", {"live.mode=on"}, 10, mode);
    all.insert(all.begin(), program.string());
    const std::string err = (scratch_.path() / "err").string();
    EXPECT_EQ(await_end(start_program(all, (scratch_.path() / "printed").string(), err)), 0);
    const json run = report("out");
    EXPECT_GT(run["frames"], 10) << text_of(err);
    EXPECT_EQ(run["health"]["worst"], "degraded");
    bool is_named = false;
    for (const json& entry : run["health"]["reasons"]) {
      is_named = is_named || entry["reason"] == "masks_missing";
    }
    EXPECT_TRUE(is_named) << run["health"];
  }
}

TEST_F(NetworkRun, SegmentWritesMasksAndPictures) {
  const ProgramResult result =
      run_kinetrace({"segment", recording_.image(0, 0).string(), recording_.image(1, 1).string(), "--model", model(),
                     "--out", out("masks").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("instances in"));
  for (const char* kind : {"masks", "overlay"}) {
    EXPECT_TRUE(fs::exists(out("masks") / kind / recording_.image(0, 0).filename())) << kind;
    EXPECT_TRUE(fs::exists(out("masks") / kind / recording_.image(1, 1).filename())) << kind;
  }
  EXPECT_EQ(run_kinetrace({"segment", "/nowhere.png", "--model", model(), "--out", out("masks").string()}).exit_code,
            66);
  EXPECT_EQ(run_kinetrace({"segment", model(), "--model", model(), "--out", out("masks").string()}).exit_code, 65)
      << "not a picture";
}

TEST_F(NetworkRun, SegmentReplacesNeitherItsPicturesNorItsResults) {
  const auto refused = [&](const std::vector<std::string>& pictures, const std::string& text, int exit_code = kUsage) {
    std::vector<std::string> arguments{"segment", "--model", model(), "--out", out("results").string()};
    arguments.insert(arguments.end(), pictures.begin(), pictures.end());
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(text));
  };
  refused({recording_.image(0, 0).string(), recording_.image(1, 0).string()}, "both would become");
  EXPECT_FALSE(fs::exists(out("results")));
  const fs::path picture = out("results") / "overlay" / "a.png";
  fs::create_directories(picture.parent_path());
  fs::copy_file(recording_.image(0, 0), picture);
  refused({picture.string()}, "a.png: would be replaced by its own result");
  const fs::path notes = out("results") / "masks" / recording_.image(0, 0).filename();
  fs::create_directories(notes.parent_path());
  std::ofstream(notes) << "notes";
  refused({recording_.image(0, 0).string()}, notes.string() + ": is there already, and is no image of masks",
          kCannotCreate);
  EXPECT_EQ(text_of(notes), "notes");
}

TEST_F(NetworkRun, SegmentFollowsTheSizeOfEachPicture) {
  const fs::path yaml = scratch_.path() / "any_size.yaml";
  std::ofstream(yaml) << "family: kinetrace-seg\nmodel: " << KINETRACE_MODELS << "/kinetrace-seg.onnx\n"
                      << "input: {pixels: 131072}\nclasses: [white, red]\nuse: {white: vehicle, red: person}\n"
                         "thresholds: {score: 0.5, overlap: 0.45}\n";
  const auto segment = [&](const std::vector<std::string>& pictures, const char* results) {
    std::vector<std::string> arguments{"segment", "--model", yaml.string(), "--out", out(results).string()};
    arguments.insert(arguments.end(), pictures.begin(), pictures.end());
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  };
  const std::string picture = recording_.image(0, 1).string();
  recording_.write_image_of_size(0, 0, 100, 300);
  recording_.write_image_of_size(0, 2, 4000, 1);
  recording_.write_image_of_size(0, 3, 1, 4000);
  segment({picture}, "alone");
  segment({recording_.image(0, 0).string(), recording_.image(0, 2).string(), recording_.image(0, 3).string(), picture},
          "among_others");
  const fs::path name = recording_.image(0, 1).filename();
  EXPECT_EQ(text_of(out("among_others") / "masks" / name), text_of(out("alone") / "masks" / name));
}

TEST_F(NetworkRun, SegmentUsesTheRightPicturesForDisparities) {
  const fs::path yaml = scratch_.path() / "stereo.yaml";
  std::ofstream(yaml) << "family: kinetrace-seg\nmodel: " << KINETRACE_MODELS << "/kinetrace-seg-stereo.onnx\n"
                      << "input: {pixels: 131072, colours: gray, mean: [0], disparity: true}\nclasses: [white, red]\n"
                         "use: {white: vehicle, red: person}\nthresholds: {score: 0.5, overlap: 0.45}\n";
  const std::string right = recording_.image(1, 0).parent_path().string();
  const ProgramResult pair = run_kinetrace({"segment", recording_.image(0, 0).string(), "--right", right, "--model",
                                            yaml.string(), "--out", out("pair").string()});
  ASSERT_EQ(pair.exit_code, 0) << pair.err;
  EXPECT_THAT(pair.out, Not(HasSubstr(": 0 instances")));
  const ProgramResult single = run_kinetrace(
      {"segment", recording_.image(0, 0).string(), "--model", yaml.string(), "--out", out("single").string()});
  EXPECT_THAT(single.out, HasSubstr(": 0 instances")) << "this network sees nothing but disparities";
  recording_.write_image_of_size(1, 0, 100, 300);
  const ProgramResult other_size = run_kinetrace({"segment", recording_.image(0, 0).string(), "--right", right,
                                                  "--model", yaml.string(), "--out", out("other_size").string()});
  EXPECT_EQ(other_size.exit_code, kBadData);
  EXPECT_THAT(other_size.err, HasSubstr(recording_.image(1, 0).string() + ": is 100x300 pixels, and "));
  fs::remove(recording_.image(1, 1));
  const ProgramResult missing = run_kinetrace({"segment", recording_.image(0, 1).string(), "--right", right, "--model",
                                               yaml.string(), "--out", out("missing").string()});
  EXPECT_EQ(missing.exit_code, 66);
  EXPECT_THAT(missing.err, HasSubstr(recording_.image(1, 1).string() + ": "));
}

TEST_F(NetworkRun, SegmentSkipsADamagedPictureAndNamesIt) {
  truncate_file(recording_.image(0, 1), 100);
  const ProgramResult result =
      run_kinetrace({"segment", recording_.image(0, 0).string(), recording_.image(0, 1).string(),
                     recording_.image(0, 2).string(), "--model", model(), "--out", out("masks").string()});
  EXPECT_EQ(result.exit_code, kBadData) << result.err;
  EXPECT_THAT(result.err, HasSubstr(recording_.image(0, 1).string() + ": "));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_TRUE(fs::exists(out("masks") / "masks" / recording_.image(0, 2).filename()));
  EXPECT_FALSE(fs::exists(out("masks") / "masks" / recording_.image(0, 1).filename()));
}

TEST_F(NetworkRun, ATensorFlowFamilyWithAnOnnxFileIsNamed) {
  const fs::path yaml = scratch_.path() / "rcnn.yaml";
  std::ofstream(yaml) << "family: mask-rcnn\nmodel: " << KINETRACE_MODELS
                      << "/yolov8-seg.onnx\nclasses: [white]\nuse: {white: vehicle}\n";
  expect_refusal(run_kinetrace({"segment", recording_.image(0, 0).string(), "--model", yaml.string(), "--out",
                                out("masks").string()}),
                 kConfig, "family mask-rcnn takes a frozen graph of TensorFlow (.pb)");
  EXPECT_FALSE(fs::exists(out("masks")));
}

TEST_F(NetworkRun, DoctorTimesIt) {
  const ProgramResult result =
      run_kinetrace({"doctor", "--set", "segmentation.mode=onnx", "--set", "segmentation.onnx.model=" + model()});
  // The exit code is not checked: the speed depends on the machine.
  EXPECT_THAT(result.out, HasSubstr("network      yolov8-seg.onnx"));
  EXPECT_THAT(result.out, HasSubstr("ms a frame"));
  const ProgramResult wrong = run_kinetrace(
      {"doctor", "--set", "segmentation.mode=onnx", "--set", "segmentation.onnx.model=" + model("nan-weights.onnx")});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.out, HasSubstr("FAIL  network"));
}

}  // namespace
}  // namespace kinetrace::test
