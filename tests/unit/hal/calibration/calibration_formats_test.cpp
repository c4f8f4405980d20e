// Calibration files of OpenCV in XML and JSON, and the factory files of ZED and DepthAI cameras.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core/persistence.hpp>

#include "calibration/calibration_files.hpp"
#include "recording_for_test.hpp"
#include "rig_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

/// A file of that name, read for images of that size.
Result<RigCalibration> read_as(const std::string& name, const std::string& text, int width_px, int height_px) {
  const kinetrace::test::TempFolder folder;
  test::write_text(folder.file(name), text);
  return read_rig_calibration(folder.file(name), width_px, height_px);
}

void expect_bad(const std::string& name, const std::string& text, const std::string& what) {
  const auto rig = read_as(name, text, 1280, 720);
  ASSERT_FALSE(rig) << "expected: " << what;
  EXPECT_EQ(rig.error().code, what.starts_with("no calibration") ? ErrorCode::kNotFound : ErrorCode::kBadCalibration);
  EXPECT_THAT(rig.error().message, HasSubstr(what));
  EXPECT_THAT(rig.error().message, HasSubstr(name));
}

// A file in this format, as OpenCV writes it.
std::string written_by_opencv(const RigCalibration& rig, int format) {
  cv::FileStorage file(format == cv::FileStorage::FORMAT_XML ? ".xml" : ".json",
                       cv::FileStorage::WRITE | cv::FileStorage::MEMORY | format);
  const auto K = [](const CameraModel& c) {
    return cv::Mat(cv::Matx33d(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1));
  };
  const auto D = [](const CameraModel& c) {
    return cv::Mat(1, 5, CV_64F, const_cast<double*>(c.distortion.data())).clone();
  };
  const Eigen::Matrix3d& R = rig.T_right_left.rotation;
  const Eigen::Vector3d& t = rig.T_right_left.translation;
  file << "calibration_time"
       << "Tue 24 Nov 2026"
       << "imageSize" << cv::Size(rig.left.width_px, rig.left.height_px);
  file << "K1" << K(rig.left) << "D1" << D(rig.left) << "K2" << K(rig.right) << "D2" << D(rig.right);
  file << "R" << cv::Mat(cv::Matx33d(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)))
       << "T" << cv::Mat(cv::Vec3d(t.x(), t.y(), t.z()));
  return file.releaseAndGetString();
}

TEST(OpencvCalibration, IsReadAsOpencvWritesItInXmlAndJson) {
  const RigCalibration truth = test::radial_rig();
  for (const auto& [name, format] :
       {std::pair{"stereo.xml", cv::FileStorage::FORMAT_XML}, std::pair{"stereo.json", cv::FileStorage::FORMAT_JSON}}) {
    const auto rig = read_as(name, written_by_opencv(truth, format), 752, 480);
    ASSERT_TRUE(rig) << rig.error().message;
    EXPECT_EQ(rig->left.fx_px, truth.left.fx_px);
    EXPECT_EQ(rig->right.distortion, truth.right.distortion);
    EXPECT_EQ(rig->right.cy_px, truth.right.cy_px);
    EXPECT_TRUE(rig->T_right_left.rotation.isApprox(truth.T_right_left.rotation, 1e-12));
    EXPECT_TRUE(rig->T_right_left.translation.isApprox(truth.T_right_left.translation, 1e-12));
  }
}

TEST(CalibrationYaml, OfTwoDocumentsIsRefused) {
  expect_bad("a.yaml", "%YAML:1.0\n---\nK1: 1\n---\nK1: 2\n", "line 4: a second document begins here");
}

TEST(OpencvXml, ReportsWhatIsMalformed) {
  const auto storage = [](const std::string& inside) {
    return "<?xml version=\"1.0\"?>\n<opencv_storage>\n" + inside + "</opencv_storage>\n";
  };
  expect_bad("a.xml", "no XML", "line 1: an element must begin here");
  expect_bad("a.xml", "<calibration></calibration>", "its root must be <opencv_storage>");
  expect_bad("a.xml", "<opencv_storage/>", "its root must be <opencv_storage>");
  expect_bad("a.xml", "<opencv_storage></opencv_storage>", "holds no values");
  expect_bad("a.xml", storage("<K1>1</K2>"), "line 3: <K1> is not closed by </K1>");
  expect_bad("a.xml", storage("<K1>1</K1><K1>2</K1>"), "<K1> is there twice");
  expect_bad("a.xml", storage("<K1><_>1</_><x>2</x></K1>"), "are mixed");
  expect_bad("a.xml", storage("<!-- "), "'<!--' does not end");
  expect_bad("a.xml", storage("<T>\"</T>"), "a text in quotes does not end");
  expect_bad("a.xml", "<opencv_storage><K1", "a tag does not end");
  expect_bad("a.xml", "<opencv_storage><K1>", "<K1> does not end");
  expect_bad("a.xml", "<opencv_storage>< >", "a tag has no name");
  std::string deep;
  for (int i = 0; i < 100; ++i) {
    deep += "<a>";
  }
  expect_bad("a.xml", storage(deep), "nested too deep");
  expect_bad("a.xml", storage("<x>1</x>"), "no calibration");
}

constexpr const char* kZed = R"([LEFT_CAM_2K]
fx=1400
[LEFT_CAM_HD]
fx=701.88
fy=701.7
cx=641.285
cy=344.18
k1=-0.175
k2=0.0283
p1=6.7e-05
p2=-0.00015
k3=4e-11
[RIGHT_CAM_HD]
fx=700.96
fy=701.11
cx=633.51
cy=359.31
k1=-0.172
k2=0.0265
p1=0.00016
p2=1e-05
k3=-1e-10
[STEREO]
Baseline=119.978
TY=0.26
TZ=-0.16
CV_HD=0.0062
RX_HD=-0.0009
RZ_HD=0.0008
[MISC]
Sensor_ID=0
)";

TEST(ZedCalibration, IsReadForTheSizeOfTheImages) {
  const auto rig = read_as("SN1234.conf", kZed, 1280, 720);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.fx_px, 701.88);
  EXPECT_EQ(rig->right.cy_px, 359.31);
  EXPECT_EQ(rig->right.distortion[2], 0.00016);
  EXPECT_EQ(rig->left.distortion[4], 4e-11);
  EXPECT_TRUE(rig->T_right_left.rotation.isApprox(so3_exp({-0.0009, 0.0062, 0.0008}), 1e-12));
  EXPECT_TRUE(rig->T_right_left.translation.isApprox(Eigen::Vector3d(-0.119978, -0.00026, 0.00016), 1e-12));
  // The right camera is to the right of the left one.
  EXPECT_GT(rig->T_right_left.inverse().translation.x(), 0.11);
}

TEST(ZedCalibration, ReportsWhatIsMissingOrNoNumber) {
  const auto without = [](const std::string& line) {
    std::string text = kZed;
    return text.erase(text.find(line), line.size());
  };
  expect_bad("SN1.conf", without("fy=701.7\n"), "left_cam_hd:fy is missing");
  expect_bad("SN1.conf", without("Baseline=119.978\n"), "stereo:baseline is missing");
  expect_bad("SN1.conf", without("119.978"), "stereo:baseline is '', which is no number");
  expect_bad("SN1.conf", "[", "left_cam_hd:fx is missing");
  EXPECT_TRUE(read_as("SN1.conf", without("TY=0.26\n"), 1280, 720));
  const auto other = read_as("SN1.conf", kZed, 640, 480);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("knows no images of 640x480; use 2208x1242"));
}

// Two cameras beside a third one, as on real devices; lengths are in centimetres.
std::string depthai(const std::string& right_extrinsics) {
  const std::string K = R"("intrinsicMatrix": [[800, 0, 640], [0, 801, 400], [0, 0, 1]], "width": 1280, "height": 800)";
  const std::string D = R"("distortionCoeff": [0.7, 0.1, 1e-5, -8e-5, 0.001, 1.06, 0.26, 0.013, 0, 0, 0, 0, 0, 0])";
  return "{\"cameraData\": [[0, {\"cameraType\": 0, " + K + ", " + D +
         R"(, "extrinsics": {"rotationMatrix": [], "toCameraSocket": -1, "translation": {"x": 0, "y": 0, "z": 0}}}],)" +
         "[1, {\"cameraType\": 0, " + K + ", " + D +
         R"(, "extrinsics": {"rotationMatrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "toCameraSocket": 2,
             "translation": {"x": -7.5, "y": 0.1, "z": 0}}}],)" +
         "[2, {\"cameraType\": 0, " + K + ", " + D + ", \"extrinsics\": " + right_extrinsics + "}]]}";
}
constexpr const char* kToColour = R"({"rotationMatrix": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "toCameraSocket": 0,
    "translation": {"x": 3.75, "y": 0, "z": 0}})";

TEST(DepthaiCalibration, FollowsTheChainFromCameraToCamera) {
  const auto rig = read_as("oak.json", depthai(kToColour), 1280, 800);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.fx_px, 800);
  EXPECT_EQ(rig->right.distortion[5], 1.06);
  // Left links to right directly; the further link of right does not matter.
  EXPECT_TRUE(rig->T_right_left.rotation.isIdentity(1e-12));
  EXPECT_TRUE(rig->T_right_left.translation.isApprox(Eigen::Vector3d(-0.075, 0.001, 0.0), 1e-12));
}

TEST(DepthaiCalibration, IsScaledAndCroppedToTheImages) {
  const auto half = read_as("oak.json", depthai(kToColour), 640, 400);
  ASSERT_TRUE(half) << half.error().message;
  EXPECT_EQ(half->left.fx_px, 400);
  EXPECT_EQ(half->left.cx_px, 319.75);
  const auto cropped = read_as("oak.json", depthai(kToColour), 1280, 720);
  ASSERT_TRUE(cropped) << cropped.error().message;
  EXPECT_EQ(cropped->left.fy_px, 801);
  EXPECT_EQ(cropped->left.cy_px, 360);
  const auto taller = read_as("oak.json", depthai(kToColour), 1280, 960);
  ASSERT_FALSE(taller);
  EXPECT_THAT(taller.error().message, HasSubstr("is for images of 1280x800"));
}

TEST(DepthaiCalibration, ReportsWhatIsMissing) {
  expect_bad("oak.json", R"({"cameraData": []})", "holds no camera of socket 1");
  expect_bad("oak.json", R"({"cameraData": 7})", "is no calibration of a DepthAI device");
  expect_bad("oak.json", R"({"cameraData": [)", "is no calibration of a DepthAI device");
  std::string apart = depthai(kToColour);
  const std::string link = "\"toCameraSocket\": 2";
  apart.replace(apart.find(link), link.size(), "\"toCameraSocket\": 1");
  expect_bad("oak.json", apart, "does not say how the left and the right camera stand to each other");
  std::string tilted = depthai(kToColour);
  const std::string zeros = "0, 0, 0, 0, 0, 0]";
  tilted.replace(tilted.rfind(zeros), zeros.size(), "0, 0, 0, 0, 0.01, 0]");
  expect_bad("oak.json", tilted, "thin prism, tilt");
  expect_bad("other.json", R"({"left": 1})", "no calibration");
}

TEST(DepthaiCalibration, SharesACameraThatBothLeadTo) {
  const std::string to_right = "\"toCameraSocket\": 2,";
  std::string text = depthai(R"({"rotationMatrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "toCameraSocket": 0,
    "translation": {"x": 3.75, "y": 0, "z": 0}})");
  text.replace(text.find(to_right), to_right.size(), "\"toCameraSocket\": 0,");
  const auto rig = read_as("oak.json", text, 1280, 800);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_TRUE(rig->T_right_left.translation.isApprox(Eigen::Vector3d(-0.1125, 0.001, 0.0), 1e-12));
}

}  // namespace
}  // namespace kinetrace::hal
