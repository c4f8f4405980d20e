// camera.tum, camera_kitti.txt, objects.csv, tracks/, label_02.txt and mots.txt, read back and compared with the truth.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "kinetrace/imaging/mask_rle.hpp"
#include "mots_rows.hpp"
#include "run_readers.hpp"
#include "spool.hpp"
#include "synthetic_run.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {
namespace {

double pose_distance(const Se3& a, const Se3& b) {
  return left_difference(a, b).norm();
}

/// A finished run of 12 frames with a car, a pedestrian and an object of unknown class.
class TrajectoryFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    SyntheticRunConfig config;
    config.frames = kFrames;
    config.objects = {{.track_id = 1, .class_id = 1, .first_frame = 0, .last_frame = 7},
                      {.track_id = 4, .class_id = 2, .first_frame = 3, .status = BodyStatus::kStereoOnly},
                      {.track_id = 1234, .class_id = 0, .first_frame = 2, .last_frame = 5}};
    RecorderFixture fixture(recording_config(folder_.path() / "run"));
    ASSERT_TRUE(fixture.recorder) << fixture.recorder.error().message;
    ASSERT_TRUE(SyntheticRun(config).play(*fixture.recorder));
    const Status finished = fixture.recorder->finish({});
    ASSERT_TRUE(finished) << finished.error().message;
  }
  [[nodiscard]] std::filesystem::path file(const char* name) const { return folder_.path() / "run" / name; }

  static constexpr int kFrames = 12;
  TemporaryFolder folder_;
};

TEST_F(TrajectoryFiles, CameraTumHasEveryFinalisedFrame) {
  const std::vector<TumRow> rows = read_tum(file("camera.tum"));
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(rows[0].timestamp, "1700000000.000000001");
  EXPECT_EQ(rows[11].timestamp, "1700000001.100000001");
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_LT(pose_distance(rows[static_cast<std::size_t>(i)].pose, SyntheticRun::T_world_cam(i)), 2e-6);
  }
}

TEST_F(TrajectoryFiles, CameraKittiHasTwelveNumbersPerFrame) {
  const std::vector<std::string> lines = read_lines(file("camera_kitti.txt"));
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const std::vector<std::string> f = split(lines[static_cast<std::size_t>(i)], ' ');
    ASSERT_EQ(f.size(), 12U);
    const Se3 truth = SyntheticRun::T_world_cam(i);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        const double expected = column < 3 ? truth.rotation(row, column) : truth.translation[row];
        EXPECT_NEAR(to_double(f[static_cast<std::size_t>(row * 4 + column)]), expected, 1e-8);
      }
    }
  }
}

TEST_F(TrajectoryFiles, ObjectsCsvHoldsFinalisedObjects) {
  const auto rows = read_csv(file("objects.csv"));
  EXPECT_EQ(rows.size(), 8U + 9U + 4U);
  const std::map<std::string, std::string> classes{{"1", "car"}, {"4", "pedestrian"}, {"1234", "unknown"}};
  for (const auto& row : rows) {
    const auto frame = static_cast<int>(to_integer(row.at("frame")));
    const auto id = static_cast<std::uint32_t>(to_integer(row.at("track_id")));
    EXPECT_EQ(to_integer(row.at("timestamp_ns")), SyntheticRun::timestamp_ns(frame));
    EXPECT_EQ(row.at("class"), classes.at(row.at("track_id")));
    EXPECT_EQ(row.at("status"), id == 4 ? "stereo_only" : "tracked");
    const auto value = [&row](const char* name) { return to_double(row.at(name)); };
    const Eigen::Quaterniond q(value("qw"), value("qx"), value("qy"), value("qz"));
    const Se3 pose{q.normalized().toRotationMatrix(), {value("tx"), value("ty"), value("tz")}};
    EXPECT_LT(pose_distance(pose, SyntheticRun::T_world_obj(id, frame)), 3e-6);
    const Box3 box = SyntheticRun::box(id, frame);
    EXPECT_NEAR(value("box_x"), box.center_m.x(), 1e-6);
    EXPECT_NEAR(value("box_l"), 4.0, 1e-9);
    EXPECT_NEAR(value("box_h"), 1.5, 1e-9);
    EXPECT_NEAR(value("box_w"), 1.8, 1e-9);
    EXPECT_NEAR(value("box_yaw"), box.yaw_rad, 1e-6);
    EXPECT_NEAR(value("heading"), box.yaw_rad, 1e-6);
    EXPECT_EQ(row.at("moving"), "1");
    EXPECT_NEAR(value("vz"), 4.0, 1e-9);
    EXPECT_NEAR(value("cov_rx"), 1e-4, 1e-12);
    EXPECT_NEAR(value("cov_tz"), 1e-4, 1e-12);
    EXPECT_EQ(row.at("point_count"), "5");
    EXPECT_EQ(row.at("pixel_height"), "7");
    EXPECT_EQ(value("mask_x1") - value("mask_x0"), 12.0);
  }
}

TEST_F(TrajectoryFiles, ObjectsCsvHeaderBeginsAsAgreed) {
  EXPECT_TRUE(read_text(file("objects.csv"))
                  .starts_with("frame,timestamp_ns,track_id,class,status,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,"));
}

TEST_F(TrajectoryFiles, EachTrackHasItsOwnFile) {
  const std::vector<TumRow> rows = read_tum(file("tracks/1234.tum"));
  ASSERT_EQ(rows.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(pose_distance(rows[static_cast<std::size_t>(i)].pose, SyntheticRun::T_world_obj(1234, i + 2)), 3e-6);
  }
  EXPECT_EQ(rows[0].timestamp, "1700000000.200000001");
  EXPECT_EQ(read_tum(file("tracks/1.tum")).size(), 8U);
  EXPECT_EQ(read_tum(file("tracks/4.tum")).size(), 9U);
  EXPECT_FALSE(std::filesystem::exists(file("tracks/0.tum")));
}

/// Corners of a KITTI label's box, projected as KITTI's own tools do.
std::vector<Eigen::Vector2d> label_corners_px(const std::vector<std::string>& f) {
  const double h = to_double(f[10]);
  const double w = to_double(f[11]);
  const double l = to_double(f[12]);
  const Eigen::Vector3d location(to_double(f[13]), to_double(f[14]), to_double(f[15]));
  const double ry = to_double(f[16]);
  std::vector<Eigen::Vector2d> corners;
  for (const double x : {-l / 2, l / 2}) {
    for (const double y : {0.0, -h}) {
      for (const double z : {-w / 2, w / 2}) {
        const Eigen::Vector3d p(std::cos(ry) * x + std::sin(ry) * z, y, -std::sin(ry) * x + std::cos(ry) * z);
        corners.push_back(SyntheticRun::geometry().project(p + location).head<2>());
      }
    }
  }
  return corners;
}

/// The same corners straight from the box in the world.
std::vector<Eigen::Vector2d> world_corners_px(const Box3& box, const Se3& T_world_cam) {
  const Eigen::Matrix3d heading = so3_exp({0.0, box.yaw_rad, 0.0});
  std::vector<Eigen::Vector2d> corners;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {0.5, -0.5}) {
      for (const double z : {-0.5, 0.5}) {
        const Eigen::Vector3d p(x * box.size_m.x(), y * box.size_m.y(), z * box.size_m.z());
        corners.push_back(
            SyntheticRun::geometry().project(T_world_cam.inverse() * (heading * p + box.center_m)).head<2>());
      }
    }
  }
  return corners;
}

TEST_F(TrajectoryFiles, KittiLabelsProjectToTheBox) {
  const std::vector<std::string> lines = read_lines(file("label_02.txt"));
  EXPECT_EQ(lines.size(), 8U + 9U + 4U);
  const std::map<std::string, std::string> types{{"1", "Car"}, {"4", "Pedestrian"}, {"1234", "Misc"}};
  const std::map<std::string, std::size_t> slots{{"1", 0}, {"4", 1}, {"1234", 2}};
  for (const std::string& line : lines) {
    const std::vector<std::string> f = split(line, ' ');
    ASSERT_EQ(f.size(), 18U);
    const auto frame = static_cast<int>(to_integer(f[0]));
    const auto id = static_cast<std::uint32_t>(to_integer(f[1]));
    EXPECT_EQ(f[2], types.at(f[1]));
    EXPECT_EQ(f[3], "-1");
    EXPECT_EQ(f[4], "-1");
    const PixelBox mask = SyntheticRun::mask_box(slots.at(f[1]), frame);
    EXPECT_EQ(to_integer(f[6]), mask.x0);
    EXPECT_EQ(to_integer(f[7]), mask.y0);
    EXPECT_EQ(to_integer(f[8]), mask.x1 - 1);
    EXPECT_EQ(to_integer(f[9]), mask.y1 - 1);
    const auto from_label = label_corners_px(f);
    const auto from_world = world_corners_px(SyntheticRun::box(id, frame), SyntheticRun::T_world_cam(frame));
    for (std::size_t i = 0; i < from_label.size(); ++i) {
      EXPECT_LT((from_label[i] - from_world[i]).norm(), 1e-3) << line;
    }
    const double ray = std::atan2(to_double(f[13]), to_double(f[15]));
    EXPECT_NEAR(std::remainder(to_double(f[16]) - ray - to_double(f[5]), 2 * std::numbers::pi), 0.0, 3e-6);
    EXPECT_EQ(f[17], id == 4 ? "0.5" : "1");
  }
}

TEST(KittiPlacement, LocationIsTheCentreOfTheBottomFaceInTheCamera) {
  Box3 box;
  box.center_m = {3.0, 1.0, 10.0};
  box.size_m = {4.0, 1.6, 1.8};
  const KittiPlacement same = kitti_placement(box, Se3{});
  EXPECT_TRUE(same.location_m.isApprox(Eigen::Vector3d(3.0, 1.8, 10.0)));
  EXPECT_NEAR(same.rotation_y_rad, 0.0, 1e-12);
  EXPECT_NEAR(same.alpha_rad, -std::atan2(3.0, 10.0), 1e-12);
}

TEST(KittiPlacement, TurningTheCameraTurnsTheBoxTheOtherWay) {
  Box3 box;
  box.yaw_rad = 3.0;
  for (const double turn : {-2.0, -0.5, 0.0, 1.0, 3.0}) {
    const KittiPlacement placement = kitti_placement(box, {so3_exp({0.0, turn, 0.0}), {0.0, 0.0, 0.0}});
    EXPECT_NEAR(std::remainder(placement.rotation_y_rad - (3.0 - turn), 2 * std::numbers::pi), 0.0, 1e-12);
    EXPECT_LE(std::abs(placement.rotation_y_rad), std::numbers::pi);
    EXPECT_LE(std::abs(placement.alpha_rad), std::numbers::pi);
  }
}

TEST_F(TrajectoryFiles, MotsHoldsEveryMaskOnceAndNoneTwiceWhileDraining) {
  const std::vector<std::string> lines = read_lines(file("mots.txt"));
  EXPECT_EQ(lines.size(), 8U + 9U + 4U);
  const std::map<std::string, std::size_t> slots{{"1001", 0}, {"2004", 1}, {"100001234", 2}};
  for (const std::string& line : lines) {
    const std::vector<std::string> f = split(line, ' ');
    ASSERT_EQ(f.size(), 6U);
    const std::size_t slot = slots.at(f[1]);
    EXPECT_EQ(f[2], slot == 0 ? "1" : slot == 1 ? "2" : "0");
    EXPECT_EQ(to_integer(f[3]), SyntheticRun::kHeight);
    EXPECT_EQ(to_integer(f[4]), SyntheticRun::kWidth);
    const PixelBox box = SyntheticRun::mask_box(slot, static_cast<int>(to_integer(f[0])));
    const auto runs = imaging::decode_mask_rle(f[5], SyntheticRun::kWidth, SyntheticRun::kHeight);
    ASSERT_TRUE(runs) << runs.error().message;
    ASSERT_EQ(static_cast<int>(runs->size()), box.width()) << "one run a column";
    for (std::size_t column = 0; column < runs->size(); ++column) {
      const std::int64_t begin = (box.x0 + static_cast<std::int64_t>(column)) * SyntheticRun::kHeight + box.y0;
      EXPECT_EQ((*runs)[column], (imaging::MaskRun{begin, begin + box.height()}));
    }
  }
}

TEST(MotsObjectId, StaysUnambiguousBeyondThreeDigits) {
  EXPECT_EQ(mots_object_id(1, 1), 1001);
  EXPECT_EQ(mots_object_id(2, 999), 2999);
  EXPECT_EQ(mots_object_id(2, 1000), 100'001'000);
  EXPECT_EQ(mots_object_id(0, 7), 7);
  EXPECT_EQ(mots_object_id(65535, 999), 65'535'999);
  EXPECT_EQ(mots_object_id(0, 0xffffffffU), 100'000'000LL + 0xffffffffLL);
}

class SingleRow : public ::testing::Test {
 protected:
  SingleRow() : buffer_(4096), out_(*BufferedWriter::create(folder_.path() / "row", buffer_)) {}
  std::string written() {
    EXPECT_TRUE(out_.flush());
    return read_text(folder_.path() / "row");
  }
  TemporaryFolder folder_;
  std::vector<std::byte> buffer_;
  BufferedWriter out_;
};

TEST_F(SingleRow, TumTimesKeepTheirNanoseconds) {
  const StoredPose identity = StoredPose::from(Se3{});
  write_tum_row(0, identity, out_);
  write_tum_row(999'999'999, identity, out_);
  write_tum_row(-1'500'000'001, identity, out_);
  write_tum_row(9'007'199'254'740'993, identity, out_);
  const std::string pose = " 0.000000 0.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000\n";
  EXPECT_EQ(written(),
            "0.000000000" + pose + "0.999999999" + pose + "-1.500000001" + pose + "9007199.254740993" + pose);
}

TEST_F(SingleRow, LostAndInvisibleObjectsHaveNoLabel) {
  ObjectResult object;
  object.status = BodyStatus::kTracked;
  write_label_row({}, object, out_);
  object.status = BodyStatus::kLost;
  object.box_px = {0, 0, 5, 5};
  write_label_row({}, object, out_);
  EXPECT_EQ(written(), "");
}

/// Tracks in an image of 5 x 4 pixels, in which each slot has one pixel.
class MotsRowsTest : public SingleRow {
 protected:
  MotsRowsTest() : rows_(held_) { std::iota(labels_.begin(), labels_.end(), std::uint8_t{1}); }
  int append(std::span<const Track> tracks) {
    FrameResult result;
    result.newest.frame_index = frame_++;
    result.tracks = tracks;
    result.left_labels = {labels_.data(), 5, 4, 5};
    return rows_.append(result, out_);
  }
  static Track track(std::uint32_t id, TrackState state) {
    return {.id = id, .slot = static_cast<std::uint8_t>(id), .state = state, .box_px = {0, 0, 5, 4}};
  }
  std::string heads() {
    std::string heads;
    for (const std::string& line : split(written(), '\n')) {
      heads += line.substr(0, line.find(" 0 4 5 ")) + ";";
    }
    return heads;
  }
  std::array<std::uint8_t, 20> labels_{};
  std::array<std::byte, 64> held_{};
  MotsRows rows_;
  std::int64_t frame_ = 0;
};

TEST_F(MotsRowsTest, TracksWithoutAPixelHaveNone) {
  FrameResult result;
  Track unseen = track(2, TrackState::kConfirmed);
  result.tracks = {&unseen, 1};
  EXPECT_EQ(rows_.append(result, out_), 0) << "no label image";
  unseen.box_px = {};
  EXPECT_EQ(append({&unseen, 1}), 0);
  EXPECT_EQ(written(), "");
}

TEST_F(MotsRowsTest, ConfirmedTracksHaveThoseOfTheirTentativeFramesInTheOrderOfFrames) {
  const std::array first{track(1, TrackState::kConfirmed), track(2, TrackState::kTentative),
                         track(3, TrackState::kPropagated)};
  EXPECT_EQ(append(first), 1) << "what follows a tentative row waits with it";
  EXPECT_EQ(append(std::span(first).subspan(1)), 0);
  const std::array second{track(2, TrackState::kConfirmed)};
  EXPECT_EQ(append(second), 5);
  EXPECT_EQ(rows_.finish(out_), 0);
  EXPECT_EQ(heads(), "0 1;0 2;0 3;1 2;1 3;2 2;");
}

TEST_F(MotsRowsTest, LostMasksHaveNone) {
  Track predicted = track(1, TrackState::kPropagated);
  EXPECT_EQ(append({&predicted, 1}), 1);
  predicted.mask_lost = true;
  EXPECT_EQ(append({&predicted, 1}), 0);
}

TEST_F(MotsRowsTest, TracksThatAreNeverConfirmedHaveNone) {
  const std::array first{track(1, TrackState::kTentative), track(2, TrackState::kTentative),
                         track(3, TrackState::kConfirmed)};
  EXPECT_EQ(append(first), 0);
  EXPECT_EQ(append(std::span(first).first(1)), 0) << "2 has ended, 1 waits";
  EXPECT_EQ(rows_.finish(out_), 1);
  EXPECT_EQ(heads(), "0 3;");
}

TEST_F(MotsRowsTest, AFullBufferDropsTentativeOnesAlone) {
  const std::array tracks{track(1, TrackState::kTentative), track(2, TrackState::kConfirmed)};
  int written = 0;
  for (int frame = 0; frame < 40; ++frame) {
    written += append(tracks);
  }
  EXPECT_EQ(written + rows_.finish(out_), 40);
  rows_ = MotsRows(std::span(held_).first(3));
  EXPECT_EQ(append(tracks), 1) << "a row larger than the buffer";
  EXPECT_EQ(rows_.finish(out_), 0);
}

}  // namespace
}  // namespace kinetrace::recording
