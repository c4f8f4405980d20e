// The summary of a run, at its end and by `kinetrace summary`.
#include <filesystem>
#include <fstream>
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

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

/// A run of two frames: a moving car, a pedestrian seen by stereo only, a lost car, a parked one.
class Summary : public ::testing::Test {
 protected:
  void write_run(const std::string& segmentation, bool with_objects) {
    std::ofstream(folder_.file("run.json"))
        << R"({"dataset": {"dataset": "folder:x", "sequence": "x"}, "frames": 2, "config": {"segmentation": {"mode": ")"
        << segmentation
        << R"("}}, "warnings": ["ended early by signal 2"], "rectified": {"width_px": 640, "height_px": 480,)"
        << R"("fx_px": 500.0, "fy_px": 500.0, "cx_px": 320.0, "cy_px": 240.0, "baseline_m": 5.37}})";
    std::ofstream(folder_.file("camera.tum")) << "1317048433.512345678 0 0 0 0 0 0 1\n"
                                                 "1317048433.612345678 0 0 1 0 0 0 1\n";
    std::ofstream(folder_.file("camera_kitti.txt")) << "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
    std::ofstream objects(folder_.file("objects.csv"));
    objects << "frame,timestamp_ns,track_id,class,status,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,moving,heading,box_x,box_y,box_"
               "z,box_l,box_h,box_w,box_yaw,cov_rx,cov_ry,cov_rz,cov_tx,cov_ty,cov_tz,point_count,inliers,pixel_height,"
               "mask_x0,mask_y0,mask_x1,mask_y1\n";
    const std::string rest = ",0,0,0,0,1,1,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
    if (with_objects) {
      objects << "0,1317048433512345678,1,car,tracked,0,0,10,0,0,0,1,0,0,-3,1" << rest
              << "0,1317048433512345678,4,car,stereo_only,0,0,48,0,0,0,1,0,0,0,0" << rest
              << "1,1317048433612345678,1,car,propagated,0,0,9,0,0,0,1,0,0,-5,0" << rest
              << "1,1317048433612345678,2,pedestrian,stereo_only,3,0,1,0,0,0,1,0,0,0,0" << rest
              << "1,1317048433612345678,3,car,lost,3,0,1,0,0,0,1,0,0,0,1" << rest
              << "1,1317048433612345678,4,car,tracked,0,0,10,0,0,0,1,0,0,0.1,0" << rest;
    }
  }

  TempFolder folder_;
};

TEST_F(Summary, IsATableOfTheObjects) {
  write_run("motion", true);
  const ProgramResult result = run_kinetrace({"summary", folder_.path().string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Found: camera: 1.00 m in 2 frames; objects: 3, of which 1 moved\n"));
  EXPECT_THAT(result.out, ContainsRegex(" 1  car +2 +yes +1\\.00 +3\\.00 +8\\.0 +tracked 1, propagated 1\n"));
  EXPECT_THAT(result.out, ContainsRegex(" 2  pedestrian +1 +\\? +\\? +\\? +3\\.0 +stereo_only 1\n"))
      << "its speed was not measured";
  EXPECT_THAT(result.out, ContainsRegex(" 4  car +2 +no +- +- +9\\.0 +tracked 1, stereo_only 1\n"))
      << "positions by stereo are off by metres";
  EXPECT_THAT(result.out, Not(ContainsRegex("\n +3  car")));
}

TEST_F(Summary, IsTheSameAsJson) {
  write_run("motion", true);
  const ProgramResult result = run_kinetrace({"summary", "--json", folder_.path().string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out, nullptr, false);
  EXPECT_EQ(json["camera"]["poses"], 2);
  EXPECT_DOUBLE_EQ(json["camera"]["path_m"], 1.0);
  EXPECT_EQ(json["objects_looked_for"], true);
  ASSERT_EQ(json["objects"].size(), 3);
  EXPECT_EQ(json["objects"][0]["class"], "car");
  EXPECT_EQ(json["objects"][0]["moved"], true);
  EXPECT_EQ(json["objects"][0]["frames_by_status"]["propagated"], 1);
  EXPECT_DOUBLE_EQ(json["objects"][1]["nearest_m"], 3.0);
  EXPECT_TRUE(json["objects"][1]["moved"].is_null());
  EXPECT_EQ(json["objects"][2]["moved"], false);
  EXPECT_TRUE(json["objects"][2]["displacement_m"].is_null());
}

TEST_F(Summary, TellsTheBaselineAndTheWarningsOfTheRun) {
  write_run("motion", true);
  const ProgramResult result = run_kinetrace({"summary", folder_.path().string()});
  EXPECT_THAT(result.out, HasSubstr("Rectified: 640x480 pixels, focal length 500.0 px, baseline 5.37 m\n"));
  EXPECT_THAT(result.out, HasSubstr("Warning of the run: ended early by signal 2\n"));
  const std::string text = run_kinetrace({"summary", "--json", folder_.path().string()}).out;
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  EXPECT_DOUBLE_EQ(json["baseline_m"], 5.37);
  EXPECT_EQ(json["warnings"], nlohmann::json({"ended early by signal 2"}));
}

TEST_F(Summary, SaysThatThereIsNoneAndWhereNoneWasLookedFor) {
  write_run("motion", false);
  EXPECT_THAT(run_kinetrace({"summary", folder_.path().string()}).out, HasSubstr("objects: none\n"));
  write_run("none", false);
  EXPECT_THAT(run_kinetrace({"summary", folder_.path().string()}).out,
              HasSubstr("objects: not looked for, segmentation is none\n"));
}

TEST_F(Summary, SaysThatARunDidNotEnd) {
  write_run("motion", true);
  std::filesystem::remove(folder_.path() / "run.json");
  const ProgramResult result = run_kinetrace({"summary", folder_.path().string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("did not end in good order"));
}

TEST_F(Summary, OfNoRunFolderIsAnError) {
  const ProgramResult result = run_kinetrace({"summary", folder_.path().string()});
  EXPECT_EQ(result.exit_code, 66);
  EXPECT_THAT(result.err, HasSubstr(folder_.path().string()));
}

TEST_F(Summary, EndsARun) {
  const SmallRecording recording{.root = folder_.path() / "recording", .frames = 12};
  recording.write();
  const std::string out = folder_.file("out");
  const std::vector<std::string> run{"run", "--dataset", recording.dataset(), "--out", out, "--segmentation", "motion"};
  const ProgramResult looked = run_kinetrace(run);
  ASSERT_EQ(looked.exit_code, 0) << looked.err;
  EXPECT_THAT(looked.out, HasSubstr("Found: camera: 0.5"));
  EXPECT_THAT(looked.out, HasSubstr("m in 12 frames; objects: none\n"));
  const std::string found = looked.out.substr(looked.out.find("Rectified: "));
  EXPECT_THAT(run_kinetrace({"summary", out}).out, HasSubstr(found.substr(0, found.find("objects: none\n"))));
  std::ifstream file(out + "/run.json");
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  EXPECT_EQ(report["config"]["segmentation"]["mode"], "motion");
  EXPECT_EQ(report["found"]["objects"], 0);
  EXPECT_NEAR(report["found"]["camera_path_m"], 11 * SmallRecording::kStep, 0.03);

  std::vector<std::string> off = run;
  off.back() = "none";
  EXPECT_THAT(run_kinetrace(off).out, HasSubstr("objects: not looked for, segmentation is none\n"));
}

}  // namespace
}  // namespace kinetrace::test
