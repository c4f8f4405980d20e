// kinetrace map, from outside: the run of an exact path, and a receiver's log of it.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "kinetrace/geo/geodesy.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "program.hpp"
#include "receiver.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using geo::Fix;
using geo::Geodetic;
using geo::PathPose;
using geo::test::drive;
using geo::test::Receiver;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

namespace fs = std::filesystem;

const Geodetic kOrigin{49.011, 8.416, 116.4};
const StereoGeometry kGeometry{
    .fx_px = 60, .fy_px = 60, .cx_px = 32, .cy_px = 16, .baseline_m = 0.5, .width_px = 64, .height_px = 32};
const Eigen::Vector3d kCar_cam(1.0, 0.5, 12.0);  // Ahead of the camera all the time.

void expect_done(const Status& status) {
  ASSERT_TRUE(status) << status.error().message;
}

void record_run(const fs::path& folder, const std::vector<PathPose>& path, const std::string& dataset) {
  recording::RecordingConfig config;
  config.directory = folder;
  config.geometry = kGeometry;
  config.mots = config.points = config.colmap = false;
  Arena arena(recording::RunRecorder::required_bytes(config));
  auto recorder = recording::RunRecorder::create(config, arena).value();
  std::int64_t frame = 0;
  for (const PathPose& pose : path) {
    ObjectResult car;
    car.track_id = 3;
    car.class_id = kVehicleClass;
    car.status = BodyStatus::kTracked;
    car.moving = true;
    car.T_world_obj = pose.T_world_cam;
    car.box.center_m = pose.T_world_cam * kCar_cam;
    car.box.size_m = {4.0, 1.5, 1.8};
    FrameResult result;
    result.newest.frame_index = frame++;
    result.newest.timestamp_ns = pose.time_ns;
    result.newest.camera.status = BodyStatus::kTracked;
    result.newest.camera.T_world_cam = pose.T_world_cam;
    result.newest.objects = std::span(&car, 1);
    result.has_finalised = true;
    result.finalised = result.newest;
    expect_done(recorder.record(result));
  }
  recording::RunSummary summary;
  summary.frames = static_cast<std::uint64_t>(path.size());
  if (!dataset.empty()) {
    summary.dataset = {{"dataset", dataset}};
  }
  expect_done(recorder.finish(summary));
}

std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) {
    sum ^= static_cast<unsigned char>(c);
  }
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + body + end;
}

std::string angle(double degrees, int digits) {
  const double whole = std::floor(degrees);
  char text[32];
  std::snprintf(text, sizeof text, "%0*d%010.7f", digits, static_cast<int>(whole), (degrees - whole) * 60.0);
  return text;
}

/// Times count from 13 September 2020, where `drive` begins.
std::string nmea(const Fix& fix, const geo::LocalFrame& frame) {
  const Geodetic place = frame.to_geodetic(fix.enu_m);
  const double day_s = std::fmod(std::round(static_cast<double>(fix.time_ns) * 1e-6) * 1e-3, 86400.0);
  char clock[32];
  std::snprintf(clock, sizeof clock, "%02d%02d%06.3f", static_cast<int>(day_s / 3600.0),
                static_cast<int>(std::fmod(day_s / 60.0, 60.0)), std::fmod(day_s, 60.0));
  char height[48];
  std::snprintf(height, sizeof height, "1,09,0.5,%.3f,M,48.0,M,,", place.height_m - 48.0);
  const std::string where = angle(place.latitude_deg, 2) + ",N," + angle(place.longitude_deg, 3) + ",E,";
  return sentence("GPRMC," + std::string(clock) + ",A," + where + "20.0,90.0,130920,,,A") +
         sentence("GPGGA," + std::string(clock) + "," + where + height);
}

class Map : public ::testing::Test {
 protected:
  /// A run of this path, and the log of a receiver on it; truth in `truth_`.
  void prepare(const geo::test::PathShape& shape) {
    std::mt19937 random(7);
    const auto path = drive(shape);
    truth_ = {.T_map_world = geo::test::any_placement(random, 0.0), .time_offset_s = 1.234, .outlier_share = 0.1};
    record_run(run(), path, dataset_);
    const auto frame = geo::LocalFrame::at(kOrigin).value();
    std::ofstream log(log_path(), std::ios::binary);
    const auto fixes = receive(path, truth_, random);
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      const std::string lines = nmea(fixes[i], frame);
      // Every fortieth is cut off; the checksum of the last line is wrong.
      log << (i % 40 == 39 ? lines.substr(0, lines.size() - 30) + "\r\n" : lines);
    }
    log << "$GPGGA,000000.00,4900.0000,N,00800.0000,E,1,09,0.5,1.0,M,48.0,M,,*00\r\n";
  }
  [[nodiscard]] fs::path run() const { return scratch_.path() / "run"; }
  [[nodiscard]] std::string log_path() const { return (scratch_.path() / "log.nmea").string(); }
  [[nodiscard]] ProgramResult map(std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"map", run().string(), "--reference", "nmea:" + log_path(), "--origin", "49.011,8.416,116.4"});
    return run_kinetrace(more);
  }
  [[nodiscard]] json report() const { return json::parse(text_of(run() / "map" / "map.json")); }

  TempFolder scratch_;
  std::string dataset_;  ///< Of the run; empty: unknown.
  Receiver truth_;
};

TEST_F(Map, PutsARunWhereTheReceiverWas) {
  prepare(geo::test::town());
  const ProgramResult result = map({"--dof", "4", "--drift", "0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("bad checksums 1"));
  const json about = report();
  EXPECT_EQ(about["verdict"], "aligned");
  EXPECT_NEAR(about["time_offset_s"].get<double>(), truth_.time_offset_s, 0.02);
  EXPECT_EQ(about["reference"]["bad_checksums"], 1);
  EXPECT_EQ(about["reference"]["malformed"], 7);
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T;
  for (int i = 0; i < 12; ++i) {
    T(i / 4, i % 4) = about["map"]["T_map_world"][static_cast<std::size_t>(i)].get<double>();
  }
  const Eigen::Matrix3d turned = truth_.T_map_world.rotation.transpose() * T.leftCols<3>();
  EXPECT_LT(so3_log(turned).norm(), 0.2 * M_PI / 180.0);
  for (const char* name :
       {"trajectories.geojson", "trajectories.kml", "trajectories.gpx", "trajectories.csv", "map.png"}) {
    EXPECT_TRUE(fs::exists(run() / "map" / name)) << name;
  }
}

TEST_F(Map, EveryTrajectoryIsInItsTable) {
  prepare(geo::test::town());
  ASSERT_EQ(map({"--dof", "4", "--quiet"}).exit_code, 0);
  auto rows = TextRows::open(run() / "map" / "trajectories.csv", TextRows::Separator::kComma).value();
  const auto columns = rows.columns({"track_id", "latitude", "longitude", "height", "frame"});
  const auto frame = geo::LocalFrame::at(kOrigin).value();
  const auto path = drive(geo::test::town());
  double worst_m = 0.0;
  std::size_t count = 0;
  while (rows.next()) {
    const PathPose& pose = path.at(static_cast<std::size_t>(rows.integer(columns[4])));
    const bool is_car = rows.integer(columns[0]) == 3;
    const Eigen::Vector3d truth =
        truth_.T_map_world * (pose.T_world_cam * (is_car ? kCar_cam : Eigen::Vector3d::Zero().eval()));
    const Eigen::Vector3d place =
        frame.to_enu({rows.number(columns[1]), rows.number(columns[2]), rows.number(columns[3])});
    worst_m = std::max(worst_m, (place - truth).norm());
    ++count;
  }
  ASSERT_TRUE(rows.status()) << rows.status().error().message;
  EXPECT_EQ(count, 2 * path.size());
  EXPECT_LT(worst_m, 0.8);
  const json features = json::parse(text_of(run() / "map" / "trajectories.geojson"))["features"];
  ASSERT_EQ(features.size(), 2U);
  EXPECT_EQ(features[1]["properties"]["name"], "car 3");
}

TEST_F(Map, AGpxOfItsOwnIsAReferenceToo) {
  prepare(geo::test::town());
  ASSERT_EQ(map({"--dof", "4", "--quiet"}).exit_code, 0);
  const std::string gpx = (run() / "map" / "trajectories.gpx").string();
  // The first track is the camera's; the car's, later in the file, has the same times and is left out.
  const ProgramResult again =
      run_kinetrace({"map", run().string(), "--reference", "gpx:" + gpx, "--dof", "6", "--drift", "0", "--json",
                     "--quiet", "--out", (scratch_.path() / "again").string()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json about = json::parse(again.out);
  EXPECT_NEAR(about["time_offset_s"].get<double>(), truth_.time_offset_s, 0.02);
  EXPECT_NEAR(about["scale"].get<double>(), 1.0, 1e-3);
  EXPECT_LT(about["fixes"]["horizontal_noise_m"].get<double>(), 0.05);
}

TEST_F(Map, RefusesAStraightLineAndLeavesNoMap) {
  prepare(geo::test::town());
  ASSERT_EQ(map({"--dof", "4", "--quiet"}).exit_code, 0);
  fs::rename(run() / "map", scratch_.path() / "map");
  fs::remove_all(run());
  prepare({});
  fs::rename(scratch_.path() / "map", run() / "map");
  const ProgramResult result = map({"--time-offset", "1.234", "--max-time-offset", "0", "--quiet"});
  expect_refusal(result, kBadData, "the rotation about the direction of travel");
  EXPECT_EQ(report()["verdict"], "refused");
  EXPECT_FALSE(fs::exists(run() / "map" / "trajectories.csv"));
  EXPECT_FALSE(fs::exists(run() / "map" / "map.png"));
}

TEST_F(Map, ReplacesNothingButAnEarlierMap) {
  prepare(geo::test::town());
  const fs::path out = scratch_.path() / "out";
  fs::create_directories(out);
  for (const char* name :
       {"map.json", "map.png", "trajectories.geojson", "trajectories.kml", "trajectories.gpx", "trajectories.csv"}) {
    std::ofstream(out / name) << "precious";
    // Aligned or refused.
    for (const char* offset : {"0", "100000"}) {
      expect_refusal(map({"--dof", "4", "--time-offset", offset, "--out", out.string()}), kCannotCreate, name);
      EXPECT_EQ(text_of(out / name), "precious");
    }
    fs::remove(out / name);
    EXPECT_TRUE(fs::is_empty(out)) << name;
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(map({"--dof", "4", "--quiet", "--out", out.string()}).exit_code, 0);
  }
}

TEST_F(Map, DoesNotReplaceItsReference) {
  prepare(geo::test::town());
  ASSERT_EQ(map({"--dof", "4", "--quiet"}).exit_code, 0);
  const fs::path gpx = run() / "map" / "trajectories.gpx";
  const std::string before = text_of(gpx);
  expect_refusal(run_kinetrace({"map", run().string(), "--reference", "gpx:" + gpx.string(), "--dof", "4"}),
                 kCannotCreate, "is the reference");
  EXPECT_EQ(text_of(gpx), before);
}

TEST_F(Map, StaysOutOfTheRecording) {
  const fs::path recording = scratch_.path() / "recording";
  fs::create_directories(recording / "image_00");
  dataset_ = "kitti-raw:" + recording.string();
  prepare(geo::test::town());
  for (const fs::path& out : {recording, recording / "image_00", recording / "map"}) {
    expect_refusal(map({"--dof", "4", "--out", out.string()}), kCannotCreate, "lies in the recording");
  }
  EXPECT_TRUE(fs::is_empty(recording / "image_00"));
}

TEST_F(Map, ReportsNothingThatWasNotEstimated) {
  prepare(geo::test::town());
  const ProgramResult result = map({"--time-offset", "100000"});
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, HasSubstr("fewer than 10 fixes"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("reference "), Not(HasSubstr("noise ")), Not(HasSubstr("scale "))));
  const json about = report();
  for (const char* name : {"horizontal_noise_m", "vertical_noise_m", "correlation"}) {
    EXPECT_TRUE(about["fixes"].at(name).is_null()) << name;
  }
  for (const char* name : {"time_offset_s", "covariance", "scale"}) {
    EXPECT_TRUE(about.at(name).is_null()) << name;
  }
  EXPECT_EQ(about["fixes"]["matched"], 0);
}

TEST_F(Map, SaysWhatIsWrongWithItsArguments) {
  prepare(geo::test::town());
  const std::string run_path = run().string();
  expect_refusal(run_kinetrace({"map", run_path}), kUsage, "--reference");
  expect_refusal(run_kinetrace({"map", run_path, "--reference", log_path()}), kUsage, "FORMAT:PATH");
  expect_refusal(run_kinetrace({"map", run_path, "--reference", "nmea:/nowhere"}), kNoInput, "/nowhere");
  expect_refusal(run_kinetrace({"map", "/nowhere", "--reference", "nmea:" + log_path()}), kNoInput, "/nowhere");
  expect_refusal(run_kinetrace({"map", run_path, "--reference", "gpx:" + log_path()}), kBadData, "log.nmea");
  expect_refusal(map({"--dof", "5"}), kUsage, "--dof");
  expect_refusal(map({"--lever-arm", "1,2"}), kUsage, "--lever-arm");
  expect_refusal(map({"--lever-arm", "1,2,x"}), kUsage, "--lever-arm");
  expect_refusal(map({"--out", log_path()}), kCannotCreate, "log.nmea");
}

}  // namespace
}  // namespace kinetrace::test
