#include <fstream>
#include <numbers>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/evaluation/truth.hpp"
#include "temp_folder.hpp"

namespace kinetrace::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr const char* kIdentity = "1 0 0 0 0 1 0 0 0 0 1 0\n";
constexpr const char* kOneMetreAhead = "1 0 0 0 0 1 0 0 0 0 1 1\n";
constexpr const char* kObjectsHeader =
    "frame,timestamp_ns,object_id,class,moving,rigid,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,length,height,width,visible_px,"
    "height_px,occlusion,truncation\n";

class TruthReader : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    std::string path = folder_.file(name);
    std::ofstream(path) << text;
    return path;
  }
  static Truth read(const TruthSource& source) {
    Result<Truth> truth = read_truth(source);
    EXPECT_TRUE(truth) << truth.error().message;
    return truth ? std::move(*truth) : Truth{};
  }
  static Error error_of(const TruthSource& source) {
    const Result<Truth> truth = read_truth(source);
    EXPECT_FALSE(truth);
    return truth ? Error{} : truth.error();
  }
  TruthSource source(const std::string& path) const {
    TruthSource wanted;
    wanted.path = path;
    return wanted;
  }

  test::TempFolder folder_;
};

TEST_F(TruthReader, TakesKittiPosesByFrame) {
  const Truth truth = read(source(write("00.txt", std::string(kIdentity) + kOneMetreAhead)));
  EXPECT_EQ(truth.format, TruthFormat::kKittiPoses);
  EXPECT_FALSE(truth.has_objects);
  EXPECT_FALSE(truth.camera.by_time);
  EXPECT_EQ(truth.camera.at(1, 12345, 0)->translation, Eigen::Vector3d(0, 0, 1));
  EXPECT_FALSE(truth.camera.at(2, 0, 0));
  EXPECT_FALSE(truth.camera.at(-1, 0, 0));
}

TEST_F(TruthReader, TakesTumByTimeAndInterpolates) {
  const Truth truth = read(source(
      write("t.txt", "# time tx ty tz qx qy qz qw\n10.00 0 0 0 0 0 0 1\n10.01 1 0 0 0 0 1 0\n10.5 5 0 0 0 0 0 1\n")));
  EXPECT_EQ(truth.format, TruthFormat::kTum);
  constexpr std::int64_t kTolerance_ns = 10'000'000;
  const auto at = [&](std::int64_t ns) { return truth.camera.at(0, ns, kTolerance_ns); };
  EXPECT_NEAR(at(10'002'500'000)->translation.x(), 0.25, 1e-9);
  EXPECT_NEAR(so3_log(at(10'002'500'000)->rotation).norm(), std::numbers::pi / 4.0, 1e-6);
  EXPECT_DOUBLE_EQ(at(10'015'000'000)->translation.x(), 1.0);
  EXPECT_DOUBLE_EQ(at(9'995'000'000)->translation.x(), 0.0);
  EXPECT_DOUBLE_EQ(at(10'500'000'000)->translation.x(), 5.0);
  EXPECT_FALSE(at(10'200'000'000));
  EXPECT_FALSE(at(9'989'999'999));
}

TEST_F(TruthReader, TakesEurocOfTheCameraWithItsPlaceOnTheBody) {
  write("state_groundtruth_estimate0/data.csv",
        "#timestamp [ns],p_RS_R_x [m],y,z,q_RS_w [],x,y,z,v\n1403636580838555648,1,2,3,0,1,0,0,0.5\n");
  TruthSource wanted = source(folder_.path().string());
  EXPECT_EQ(error_of(wanted).code, ErrorCode::kInvalidArgument);
  wanted.T_body_cam = Se3{Eigen::Matrix3d::Identity(), {0.0, 0.1, 0.0}};
  const Truth truth = read(wanted);
  EXPECT_EQ(truth.format, TruthFormat::kEuroc);
  // Half a turn about x: the real part is zero.
  const Se3 pose = truth.camera.at(0, 1'403'636'580'838'555'648, 0).value();
  EXPECT_NEAR((pose.translation - Eigen::Vector3d(1.0, 1.9, 3.0)).norm(), 0.0, 1e-12);
}

TEST_F(TruthReader, TakesTheSimulatorsFolderOrTheOneAboveIt) {
  write("truth/camera_poses.txt", kIdentity);
  write("truth/objects.csv", std::string(kObjectsHeader) +
                                 "0,5,3,car,1,1,1,2,10,0,0,0,1,0.1,0.2,0.3,4,1.5,2,900,45,0,0\n"
                                 "0,5,4,pedestrian,1,0,1,2,10,0,0,0,1,0,0,0,4,1.5,2,0,0,0,0\n");
  std::filesystem::create_directories(folder_.path() / "truth/masks/instances_left");
  for (const std::filesystem::path& path : {folder_.path(), folder_.path() / "truth"}) {
    const Truth truth = read(source(path.string()));
    EXPECT_EQ(truth.format, TruthFormat::kSimulator);
    EXPECT_TRUE(truth.is_complete);
    EXPECT_EQ(truth.mask_folder, folder_.path() / "truth/masks/instances_left");
    ASSERT_EQ(truth.objects.at(0).size(), 1U) << "what cannot be seen is left out";
    const LocatedObject& located = truth.objects.at(0)[0];
    EXPECT_EQ(located.object.id, 3U);
    EXPECT_EQ(located.object.class_id, 1);
    EXPECT_TRUE(located.object.moving);
    EXPECT_TRUE(located.object.rigid);
    EXPECT_EQ(located.object.height_px, 45);
    EXPECT_EQ(located.object.velocity_mps, Eigen::Vector3d(0.1, 0.2, 0.3));
    EXPECT_EQ(located.center_m, Eigen::Vector3d(1.0, 1.25, 10.0));
  }
}

TEST_F(TruthReader, TurnsKittiLabelsIntoTheWorld) {
  std::string labels = "0 -1 DontCare -1 -1 -10 1 2 3 4 -1 -1 -1 -1000 -1000 -1000 -10\n";
  std::string poses;
  TruthSource wanted;
  for (int frame = 0; frame < 6; ++frame) {
    // The camera drives at 1 m a frame; the car stays 10 m ahead of it.
    labels += std::to_string(frame) + " 2 Car 0 0 -1.5 100 50 140.5 90.5 1.5 1.6 4 1 2 10 0.5\n";
    poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(frame) + "\n";
    wanted.frame_times_ns[frame] = std::int64_t{frame} * 100'000'000;
  }
  wanted.path = write("labels.txt", labels);
  EXPECT_THAT(error_of(wanted).message, HasSubstr("camera poses"));
  wanted.camera = write("poses.txt", poses);
  const Truth truth = read(wanted);
  EXPECT_EQ(truth.format, TruthFormat::kKittiTracking);
  EXPECT_TRUE(truth.has_boxes);
  EXPECT_FALSE(truth.is_complete);
  ASSERT_EQ(truth.objects.size(), 6U);
  for (const auto& [frame, objects] : truth.objects) {
    ASSERT_EQ(objects.size(), 1U);
    const LocatedObject& car = objects[0];
    EXPECT_EQ(car.object.id, 2U);
    EXPECT_EQ(car.object.height_px, 41);
    EXPECT_DOUBLE_EQ(car.box_px.x1, 140.5);
    EXPECT_NEAR((car.object.T_world_obj.translation - Eigen::Vector3d(1, 2, 10.0 + static_cast<double>(frame))).norm(),
                0.0, 1e-12);
    // rotation_y = 0.5: forward is (cos, 0, -sin).
    EXPECT_NEAR((car.object.T_world_obj.rotation.col(0) - Eigen::Vector3d(std::cos(0.5), 0, -std::sin(0.5))).norm(),
                0.0, 1e-12);
    EXPECT_NEAR((car.object.velocity_mps - Eigen::Vector3d(0, 0, 10)).norm(), 0.0, 1e-9);
    EXPECT_TRUE(car.object.moving);
    EXPECT_NEAR(car.center_m.y(), 1.25, 1e-12);
  }
}

TEST_F(TruthReader, NamesFileAndLineOfAMistake) {
  EXPECT_THAT(error_of(source(write("a.txt", std::string(kIdentity) + "1 0 0 0 0 1 0 0 0 0 1\n"))).message,
              HasSubstr("a.txt, line 2: expected 12 fields, found 11"));
  EXPECT_THAT(error_of(source(write("b.txt", std::string(kIdentity) + "1 0 0 0 0 1 0 0 0 0 1 nan\n"))).message,
              HasSubstr("b.txt, line 2: 'nan' is no finite number"));
  EXPECT_THAT(error_of(source(write("c.txt", "1 0 0 0 0 0 0 1\n\n# note\n1 0 0 0 0 0 0 1\n"))).message,
              HasSubstr("c.txt, line 4: the time does not grow"));
  EXPECT_THAT(error_of(source(write("d.txt", std::string(kIdentity) + "2 0 0 0 0 1 0 0 0 0 1 0\n"))).message,
              HasSubstr("d.txt, line 2"));
  write("sim/camera_poses.txt", kIdentity);
  write("sim/objects.csv", std::string(kObjectsHeader) + "0,5,3,car,1,1\n");
  EXPECT_THAT(error_of(source((folder_.path() / "sim").string())).message,
              HasSubstr("objects.csv, line 2: expected 23 fields, found 6"));
  write("sim/objects.csv", "frame,object_id\n");
  EXPECT_THAT(error_of(source((folder_.path() / "sim").string())).message, HasSubstr("column 'class' is missing"));
}

TEST_F(TruthReader, RefusesRowsThatAreDoubledCutOrMissing) {
  TruthSource labels;
  const auto label_error = [&](const std::string& text) {
    labels.path = write("labels.txt", text);
    labels.format = TruthFormat::kKittiTracking;
    labels.camera = write("poses.txt", kIdentity);
    labels.frame_times_ns = {{0, 0}};
    return error_of(labels).message;
  };
  const std::string car = "0 2 Car 0 0 -1.5 100 50 140.5 90.5 1.5 1.6 4 1 2 10 0.5";
  EXPECT_THAT(label_error(""), HasSubstr("labels.txt, line 0: the file holds no label"));
  EXPECT_THAT(label_error(car + "\n" + car + "\n"), HasSubstr("line 2: frame 0 has track 2 twice"));
  EXPECT_THAT(label_error("0 2 Car 0 -1.5 100 50 140.5 90.5 1.5 1.6 4 1 2 10 0.5\n"),
              HasSubstr("line 1: expected 17 fields, or 18 with a score, found 16"));
  EXPECT_THAT(error_of(source(write("e.csv", "1,0,0,0,1,0,0,0,5\n2,0,0,0,1,0,0,0\n"))).message,
              HasSubstr("sensor.yaml"));
  TruthSource euroc = source(write("e.csv", "1,0,0,0,1,0,0,0,5\n2,0,0,0,1,0,0,0\n"));
  euroc.T_body_cam = Se3{};
  EXPECT_THAT(error_of(euroc).message, HasSubstr("e.csv, line 2: expected 9 fields, found 8"));
}

TEST_F(TruthReader, RefusesASimulatorsFolderWhosePartsDoNotFit) {
  const std::string row = "0,5,3,car,1,1,1,2,10,0,0,0,1,0.1,0.2,0.3,4,1.5,2,900,45,0,0\n";
  const auto folder_error = [&](const std::string& poses, const std::string& rows) {
    write("sim/camera_poses.txt", poses);
    write("sim/objects.csv", kObjectsHeader + rows);
    return error_of(source((folder_.path() / "sim").string())).message;
  };
  EXPECT_THAT(folder_error(kIdentity, row + row), HasSubstr("objects.csv, line 3: frame 0 has object 3 twice"));
  EXPECT_THAT(folder_error(kIdentity, row.substr(0, row.size() - 1)), HasSubstr("the last row is cut off"));
  EXPECT_THAT(folder_error(kIdentity, row + "1" + row.substr(1)),
              HasSubstr("camera_poses.txt: has 1 rows, objects.csv continues until frame 1"));
  write("sim/masks/instances_left/0000000000.png", "");
  EXPECT_THAT(folder_error(std::string(kIdentity) + kIdentity, row), HasSubstr("has 2 rows"));
  write("sim/masks/instances_left/0000000001.png", "");
  EXPECT_TRUE(read_truth(source((folder_.path() / "sim").string())));
}

TEST_F(TruthReader, RefusesWhatIsNoFile) {
  const std::filesystem::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {pipe, std::filesystem::path("/dev/zero")}) {
    EXPECT_THAT(error_of(source(path.string())).message, HasSubstr(path.string() + ": is a "));
  }
}

TEST_F(TruthReader, SaysWhatItDoesNotRecognise) {
  EXPECT_EQ(error_of(source(write("x.txt", "hello world\n"))).code, ErrorCode::kUnsupported);
  EXPECT_EQ(error_of(source(write("empty.txt", ""))).code, ErrorCode::kUnsupported);
  EXPECT_EQ(error_of(source(folder_.path().string())).code, ErrorCode::kUnsupported);
  EXPECT_EQ(error_of(source("/no/such/place")).code, ErrorCode::kNotFound);
}

TEST_F(TruthReader, AcceptsAFormatThatIsGiven) {
  TruthSource wanted = source(write("poses.txt", kIdentity));
  wanted.format = TruthFormat::kTum;
  EXPECT_EQ(error_of(wanted).code, ErrorCode::kBadFormat);
}

TEST_F(TruthReader, FindsMaskImagesByFrame) {
  TruthSource wanted = source(write("poses.txt", kIdentity));
  wanted.masks = folder_.path() / "masks";
  EXPECT_EQ(error_of(wanted).code, ErrorCode::kNotFound);
  write("masks/0000000007.png", "");
  write("masks/000008.png", "");
  const Truth truth = read(wanted);
  EXPECT_EQ(mask_path(truth, 7)->filename(), "0000000007.png");
  EXPECT_EQ(mask_path(truth, 8)->filename(), "000008.png");
  EXPECT_FALSE(mask_path(truth, 9));
}

}  // namespace
}  // namespace kinetrace::evaluation
