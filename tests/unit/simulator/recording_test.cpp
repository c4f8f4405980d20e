// The files, read back by their actual readers.
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "alignment.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "output/recording_writer.hpp"
#include "output/truth_text.hpp"
#include "small_simulator.hpp"
#include "temp_folder.hpp"

namespace kinetrace::simulator {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 3;

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    lines.push_back(line);
  }
  return lines;
}

class Recording : public ::testing::Test {
 protected:
  fs::path record(StereoSimulator& simulator, bool degrade = true) {
    RecordingWriter writer = RecordingWriter::create({folder_.path() / "sim", degrade, {}}, simulator).value();
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_TRUE(writer.write(simulator.frame(i)));
    }
    EXPECT_TRUE(writer.finish());
    return writer.drive();
  }
  fs::path truth() const { return folder_.path() / "sim" / "truth"; }

  kinetrace::test::TempFolder folder_;
};

TEST_F(Recording, IsAKittiRawDrive) {
  StereoSimulator simulator = small_simulator("street", {}, 250);
  const fs::path drive = record(simulator);
  EXPECT_TRUE(drive.filename().string().ends_with("_sync"));
  const Result<hal::Dataset> dataset = hal::open_dataset({hal::DatasetLayout::kKittiRaw, drive, "", {}, 0.0});
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NEAR(dataset->nominal_rate_hz, 10.0, 1e-9);
  EXPECT_TRUE(dataset->notes.empty());
  ASSERT_TRUE(dataset->calibration.rectified);
  const StereoGeometry& g = simulator.scene().rig;
  EXPECT_NEAR(dataset->calibration.rectified->fx_px, g.fx_px, 1e-9);
  EXPECT_NEAR(dataset->calibration.rectified->cy_px, g.cy_px, 1e-9);
  EXPECT_NEAR(dataset->calibration.rectified->baseline_m, g.baseline_m, 1e-9);
}

TEST_F(Recording, CarriesTheTimesOfItsTruth) {
  StereoSimulator simulator = small_simulator("drone", {}, 250);
  const Result<hal::Dataset> dataset =
      hal::open_dataset({hal::DatasetLayout::kKittiRaw, record(simulator), "", {}, 0.0});
  ASSERT_TRUE(dataset) << dataset.error().message;
  const std::size_t bytes = hal::FileStereoCamera::required_bytes(*dataset, {});
  Arena arena(bytes);
  Result<hal::FileStereoCamera> camera = hal::FileStereoCamera::create(*dataset, {}, arena);
  ASSERT_TRUE(camera) << camera.error().message;
  ASSERT_TRUE(camera->open());
  ASSERT_TRUE(camera->start());
  for (int i = 0; i < kFrames; ++i) {
    const Result<StereoFrame> frame = camera->next(std::chrono::milliseconds(100));
    ASSERT_TRUE(frame) << frame.error().message;
    const SimulatedFrame truth = simulator.frame(i);
    EXPECT_EQ(frame->timestamp_ns, truth.timestamp_ns);
    EXPECT_EQ(frame->left.at(100, 50), truth.pictures[0].at(100, 50));
    EXPECT_EQ(frame->right.at(200, 70), truth.pictures[1].at(200, 70));
  }
}

// Pixels of a view, owned for the alignment.
Image<std::uint8_t> copied(GrayView view) {
  Image<std::uint8_t> image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) {
    std::copy_n(view.row(y), view.width, &image.at(0, y));
  }
  return image;
}

TEST_F(Recording, OfDistortedLensesIsRectifiedByItsCalibration) {
  SimulatorSettings settings = clean_settings();
  StereoSimulator straight = small_simulator("street", settings, 621);
  settings.distortion = true;
  StereoSimulator distorted = small_simulator("street", settings, 621);
  const fs::path drive = record(distorted);
  EXPECT_TRUE(drive.filename().string().ends_with("_extract"));
  const Result<hal::Dataset> dataset = hal::open_dataset({hal::DatasetLayout::kKittiRaw, drive, "", {}, 0.0});
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_TRUE(dataset->calibration.given);
  Arena arena(hal::Rectifier::required_bytes(dataset->calibration, {}));
  Result<hal::Rectifier> rectifier = hal::Rectifier::create(dataset->calibration, {}, arena);
  ASSERT_TRUE(rectifier) << rectifier.error().message;
  const SimulatedFrame raw = distorted.frame(1);
  const Result<RectifiedPair> pair =
      rectifier->process({1, raw.timestamp_ns, "", raw.pictures[0].view(), raw.pictures[1].view()});
  ASSERT_TRUE(pair) << pair.error().message;
  const SimulatedFrame truth = straight.frame(1);
  EXPECT_EQ(raw.instances[0].pixels(), truth.instances[0].pixels());
  for (std::size_t side = 0; side < 2; ++side) {
    const Image<std::uint8_t> rectified = copied(side == 0 ? pair->left : pair->right);
    const Alignment fit =
        align({truth.pictures[side], truth.depth_m[side]}, {rectified, truth.depth_m[side]},
              [](int u, int v, double depth_m) { return std::optional(Eigen::Vector3d(u, v, depth_m)); });
    EXPECT_GT(fit.count, 40000);
    EXPECT_LT(fit.mean_abs_levels, 5.0);
    EXPECT_NEAR(fit.offset_px.x(), 0.0, 0.03);
    EXPECT_NEAR(fit.offset_px.y(), 0.0, 0.03);
  }
}

TEST_F(Recording, HasALineOfTruthForEveryFrameAndObject) {
  StereoSimulator simulator = small_simulator("street", {}, 250);
  record(simulator);
  EXPECT_EQ(lines_of(truth() / "camera_poses.txt").size(), static_cast<std::size_t>(kFrames));
  const std::vector<std::string> objects = lines_of(truth() / "objects.csv");
  ASSERT_EQ(objects.size(), 1 + kFrames * simulator.scene().actors.size());
  const auto columns = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  EXPECT_EQ(columns(objects[0]), columns(objects[1]));
}

TEST_F(Recording, MasksAndDepthAreThoseOfTheSimulator) {
  StereoSimulator simulator = small_simulator("street", {}, 250);
  record(simulator, false);
  const SimulatedFrame frame = simulator.frame(2);
  const StereoGeometry& g = simulator.scene().rig;
  Arena arena(std::size_t{16} << 20);
  imaging::ImageReader reader = imaging::ImageReader::create({}, arena).value();
  const ImageView<std::uint16_t> image = take_image<std::uint16_t>(arena, g.width_px, g.height_px);
  const auto read = [&](const char* what) {
    return reader.read_gray16((truth() / what / "0000000002.png").c_str(), image);
  };
  ASSERT_TRUE(read("masks/instances_right"));
  for (int y = 0; y < g.height_px; ++y) {
    for (int x = 0; x < g.width_px; ++x) {
      ASSERT_EQ(image.at(x, y), frame.instances[1].at(x, y));
    }
  }
  ASSERT_TRUE(read("depth/left"));
  for (int y = 0; y < g.height_px; ++y) {
    for (int x = 0; x < g.width_px; ++x) {
      const auto depth_m = static_cast<double>(frame.depth_m[0].at(x, y));
      // Sixteen bits end short of 256 m.
      ASSERT_NEAR(image.at(x, y) / 256.0, depth_m < 255.99 ? depth_m : 0.0, 1.0 / 512.0 + 1e-6);
    }
  }
  // Not degraded: the same shapes, other numbers.
  ASSERT_TRUE(read("masks/detections_left"));
  for (int y = 0; y < g.height_px; ++y) {
    for (int x = 0; x < g.width_px; ++x) {
      ASSERT_EQ(image.at(x, y) / 1000, frame.instances[0].at(x, y) / 1000);
    }
  }
}

TEST_F(Recording, ReplacesAnEarlierSimulationOnly) {
  StereoSimulator simulator = small_simulator("static", {}, 128);
  record(simulator);
  EXPECT_TRUE(RecordingWriter::create({folder_.path() / "sim", true, {}}, simulator).value().replaced());
  const fs::path other = folder_.path() / "precious";
  fs::create_directories(other);
  std::ofstream(other / "thesis.txt") << "years of work";
  const Result<RecordingWriter> refused = RecordingWriter::create({other, true, {}}, simulator);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("precious"), std::string::npos);
  EXPECT_TRUE(fs::exists(other / "thesis.txt"));
}

TEST(TruthText, WritesKittiTimes) {
  EXPECT_EQ(timestamp_text(1'767'225'600'050'000'000), "2026-01-01 00:00:00.050000000");
  EXPECT_EQ(timestamp_text(1'767'225'661'000'000'001), "2026-01-01 00:01:01.000000001");
}

TEST(TruthText, LabelsSayWhereTheBoxIsInTheCamera) {
  SimulatedFrame frame;
  frame.index = 4;
  frame.T_world_cam.translation = {1.0, 0.0, 2.0};
  ObjectTruth object;
  object.id = 9;
  object.class_id = kVehicleClass;
  object.visible_px = 10;
  object.size_lhw_m = {4.0, 1.5, 1.8};
  object.T_world_obj.translation = {1.0, 1.6, 12.0};
  // Heading along the optical axis.
  object.T_world_obj.rotation = so3_exp({0.0, -1.5707963267948966, 0.0});
  object.projected_px = {10, 20, 30, 40};
  std::ostringstream out;
  write_label(frame, object, out);
  std::istringstream in(out.str());
  int index = 0;
  int id = 0;
  std::string type;
  int truncated = -1;
  int occluded = -1;
  in >> index >> id >> type >> truncated >> occluded;
  EXPECT_EQ(index, 4);
  EXPECT_EQ(id, 9);
  EXPECT_EQ(type, "Car");
  EXPECT_EQ(truncated, 0);
  EXPECT_EQ(occluded, 0);
  std::array<double, 12> values{};
  for (double& value : values) {
    in >> value;
  }
  const std::array<double, 12> expected{-1.570796, 10, 20, 30, 40, 1.5, 1.8, 4.0, 0.0, 1.6, 10.0, -1.570796};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(values[i], expected[i], 1e-5) << i;
  }
  object.visible_px = 0;
  std::ostringstream hidden;
  write_label(frame, object, hidden);
  EXPECT_TRUE(hidden.str().empty());
}

}  // namespace
}  // namespace kinetrace::simulator
