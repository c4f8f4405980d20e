// The object-size study against a truth written by hand: a car that goes 1 m a frame, in images of 40 x 30 pixels.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/png_writer.hpp"
#include "study/study_errors.hpp"
#include "study/study_summary.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 40;
constexpr int kHeight = 30;
constexpr int kFrames = 4;
constexpr PixelBox kCar{10, 5, 30, 25};
constexpr std::uint32_t kTrackId = 7;
constexpr double kDepth_m = 20.0;

template <typename Pixel>
std::vector<Pixel> image(Pixel on_car, Pixel elsewhere) {
  std::vector<Pixel> pixels;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      pixels.push_back(x >= kCar.x0 && x < kCar.x1 && y >= kCar.y0 && y < kCar.y1 ? on_car : elsewhere);
    }
  }
  return pixels;
}

template <typename Pixel>
ImageView<const Pixel> view(const std::vector<Pixel>& pixels) {
  return {pixels.data(), kWidth, kHeight, kWidth};
}

/// The car's true pose: its box is 1.5 m high.
Se3 T_world_car(int frame) {
  return {Eigen::Matrix3d::Identity(), {0.0, 1.6, kDepth_m + frame}};
}

class ObjectSizeStudy : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "study.XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    const fs::path truth = folder_ / "truth";
    fs::create_directories(truth / "masks" / "instances_left");
    fs::create_directories(truth / "depth" / "left");
    std::ofstream poses(truth / "camera_poses.txt");
    std::ofstream objects(truth / "objects.csv");
    objects << "frame,timestamp_ns,object_id,class,moving,rigid,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,length,height,width,"
               "visible_px,height_px,occlusion,truncation\n";
    for (int frame = 0; frame < kFrames; ++frame) {
      poses << "1 0 0 0 0 1 0 0 0 0 1 0\n";
      objects << frame << "," << frame * 100 << ",1,car,1,1,0,1.6," << kDepth_m + frame
              << ",0,0,0,1,0,0,10,4,1.5,1.8,400,20,0,0\n";
      const std::string file = "000000000" + std::to_string(frame) + ".png";
      const auto depth = static_cast<std::uint16_t>(256.0 * (kDepth_m + frame));
      ASSERT_TRUE(imaging::write_png_gray16((truth / "masks" / "instances_left" / file).c_str(),
                                            view(image<std::uint16_t>(1001, 0))));
      ASSERT_TRUE(imaging::write_png_gray16((truth / "depth" / "left" / file).c_str(),
                                            view(image<std::uint16_t>(depth, 60000))));
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  StudyTruth truth() {
    Result<StudyTruth> opened = StudyTruth::open(folder_);
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(*opened);
  }

  /// A run's estimate of one frame.
  struct Estimate {
    Se3 T_world_obj;
    double point_offset_m = 0.0;  ///< Of all points along the viewing direction.
    BodyStatus status = BodyStatus::kTracked;
    bool has_mask = true;
  };
  /// The study's rows of a run with these estimates.
  std::vector<StudyRow> study(const std::vector<Estimate>& estimates) {
    StudyTruth truth = this->truth();
    StudyErrors errors(truth);
    const std::vector<std::uint8_t> gray = image<std::uint8_t>(0, 0);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      const Estimate& estimate = estimates[i];
      const auto frame = static_cast<std::int64_t>(i);
      ObjectResult object;
      object.track_id = kTrackId;
      object.status = estimate.status;
      object.T_obj_cam = estimate.T_world_obj.inverse();
      object.T_world_obj = estimate.T_world_obj;
      object.box = {.center_m = estimate.T_world_obj * Eigen::Vector3d(0.0, -0.75, 0.0), .size_m = {4.0, 1.5, 1.8}};
      const std::vector<std::uint8_t> labels = image<std::uint8_t>(estimate.has_mask ? 3 : 0, 0);
      std::vector<Track> tracks(1);
      tracks[0].id = kTrackId;
      tracks[0].slot = 2;
      std::vector<BodyPoint> points;
      std::vector<PointObservation> observations;
      for (std::uint32_t id = 0; id < 8; ++id) {
        const Eigen::Vector3d p_cam(0.1 * id, 0.0, kDepth_m + static_cast<double>(i) + estimate.point_offset_m);
        BodyPoint& point = points.emplace_back();
        point.id = id;
        point.position_m = (object.T_obj_cam * p_cam).cast<float>();
        point.observations = id == 7 ? 1 : 2;
        observations.push_back({id, 15.F + static_cast<float>(id), 10.F, 5.F});
      }
      std::vector<BodyGeometry> bodies(1);
      bodies[0].track_id = kTrackId;
      bodies[0].points = points;
      bodies[0].observations = observations;
      FrameResult result;
      result.newest = {frame, frame * 100, {}, {&object, 1}};
      result.has_finalised = true;
      result.finalised = result.newest;
      result.bodies = bodies;
      result.tracks = tracks;
      result.pair.left = view(gray);
      result.left_labels = view(labels);
      const Status added = errors.add(result);
      EXPECT_TRUE(added) << added.error().message;
    }
    return errors.rows();
  }
  static std::vector<Estimate> exact() {
    std::vector<Estimate> estimates;
    estimates.reserve(kFrames);
    for (int frame = 0; frame < kFrames; ++frame) {
      estimates.push_back({T_world_car(frame)});
    }
    return estimates;
  }

  fs::path folder_;
};

TEST_F(ObjectSizeStudy, FindsNoErrorInTheTruthItself) {
  const std::vector<StudyRow> rows = study(exact());
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].frame, static_cast<std::int64_t>(i));
    EXPECT_EQ(rows[i].object_id, 1U);
    EXPECT_EQ(rows[i].track_id, kTrackId);
    EXPECT_EQ(rows[i].height_px, 20);
    EXPECT_NEAR(rows[i].distance_m, std::hypot(1.6 - 0.75, kDepth_m + static_cast<double>(i)), 1e-9);
    EXPECT_EQ(rows[i].points, 7) << "the eighth was seen once";
    EXPECT_NEAR(*rows[i].position_m, 0.0, 1e-9);
    EXPECT_NEAR(*rows[i].center_m, 0.0, 1e-9);
    EXPECT_NEAR(*rows[i].depth_bias_m, 0.0, 1e-5);
    EXPECT_NEAR(*rows[i].shape_m, 0.0, 1e-5);
    EXPECT_EQ(*rows[i].wrong_points, 0.0);
    EXPECT_EQ(rows[i].motion_m.has_value(), i > 0);
    if (i > 0) {
      EXPECT_NEAR(*rows[i].motion_m, 0.0, 1e-9);
      EXPECT_NEAR(*rows[i].motion_deg, 0.0, 1e-6);
    }
  }
}

TEST_F(ObjectSizeStudy, DoesNotMindWhereTheEstimatedFrameLies) {
  const Se3 offset{so3_exp({0.3, -1.0, 0.2}), {2.0, 0.5, -1.0}};
  std::vector<Estimate> estimates = exact();
  for (Estimate& estimate : estimates) {
    estimate.T_world_obj = estimate.T_world_obj * offset;
  }
  const std::vector<StudyRow> rows = study(estimates);
  EXPECT_NEAR(*rows[2].position_m, 0.0, 1e-9);
  EXPECT_NEAR(*rows[2].motion_m, 0.0, 1e-9);
  EXPECT_NEAR(*rows[2].motion_deg, 0.0, 1e-6);
  EXPECT_GT(*rows[2].center_m, 1.0) << "no offset is removed here";
}

TEST_F(ObjectSizeStudy, MeasuresAKnownJump) {
  std::vector<Estimate> estimates = exact();
  estimates[2].T_world_obj.translation.x() += 0.3;
  const std::vector<StudyRow> rows = study(estimates);
  EXPECT_NEAR(*rows[1].motion_m, 0.0, 1e-9);
  EXPECT_NEAR(*rows[2].motion_m, 0.3, 1e-9);
  EXPECT_NEAR(*rows[3].motion_m, 0.3, 1e-9) << "back again";
  EXPECT_NEAR(*rows[2].center_m, 0.3, 1e-9);
  EXPECT_NEAR(*rows[2].position_m + *rows[1].position_m, 0.3, 1e-9) << "on either side of the best offset";
  EXPECT_GT(*rows[2].position_m, *rows[1].position_m);
}

TEST_F(ObjectSizeStudy, MeasuresAKnownTurn) {
  std::vector<Estimate> estimates = exact();
  estimates[3].T_world_obj.rotation = so3_exp({0.0, 0.01, 0.0});
  const std::vector<StudyRow> rows = study(estimates);
  EXPECT_NEAR(*rows[3].motion_deg, 0.01 * 180.0 / M_PI, 1e-9);
  EXPECT_NEAR(*rows[2].motion_deg, 0.0, 1e-6);
}

TEST_F(ObjectSizeStudy, TellsASurfaceTooFarFromAWrongShape) {
  std::vector<Estimate> estimates = exact();
  estimates[1].point_offset_m = 0.5;
  estimates[2].point_offset_m = -5.0;
  const std::vector<StudyRow> rows = study(estimates);
  EXPECT_NEAR(*rows[1].depth_bias_m, 0.5, 1e-5);
  EXPECT_NEAR(*rows[1].depth_m, 0.5, 1e-5);
  EXPECT_NEAR(*rows[1].shape_m, 0.0, 1e-5);
  EXPECT_NEAR(*rows[2].depth_bias_m, -5.0, 1e-5);
  EXPECT_EQ(*rows[2].wrong_points, 1.0) << "5 m of 22 m";
}

TEST_F(ObjectSizeStudy, MeasuresNothingWithoutMaskOrReconstruction) {
  std::vector<Estimate> estimates = exact();
  estimates[1].has_mask = false;
  estimates[3].status = BodyStatus::kStereoOnly;
  const std::vector<StudyRow> rows = study(estimates);
  EXPECT_EQ(rows[1].track_id, 0U);
  EXPECT_EQ(rows[1].status, BodyStatus::kLost);
  EXPECT_FALSE(rows[1].position_m || rows[1].depth_m || rows[1].motion_m);
  EXPECT_FALSE(rows[2].motion_m) << "the frame before has no pose";
  EXPECT_EQ(rows[3].status, BodyStatus::kStereoOnly);
  EXPECT_FALSE(rows[3].position_m || rows[3].depth_m || rows[3].motion_m);
}

TEST_F(ObjectSizeStudy, KnowsDepthOnlyWhereFourPixelsAgree) {
  StudyTruth truth = this->truth();
  const Result<TrueImages> images = truth.images(1);
  ASSERT_TRUE(images) << images.error().message;
  const std::uint8_t label = images->masks.instances.front().label;
  EXPECT_NEAR(*images->depth_at(15.25, 10.75, label), 21.0, 1e-9);
  EXPECT_NEAR(*images->depth_at(kCar.x0, kCar.y0, label), 21.0, 1e-9);
  EXPECT_FALSE(images->depth_at(kCar.x0 - 0.1, 10.0, label));
  EXPECT_FALSE(images->depth_at(kCar.x1 - 0.9, 10.0, label));
  EXPECT_FALSE(images->depth_at(-1.0, 10.0, label));
  EXPECT_FALSE(images->depth_at(kWidth - 0.5, 10.0, label));
  EXPECT_FALSE(images->depth_at(15.0, 10.0, 9)) << "another object";
}

TEST(TrueDepth, IsThatOfAPlaneAndUnknownOnEdges) {
  const std::vector<std::uint8_t> labels(4, 1);
  const auto depth_between = [&](std::uint16_t left, std::uint16_t right) {
    const std::vector<std::uint16_t> depth{left, right, left, right};
    return TrueImages{{labels, 2, 2, {}}, {depth.data(), 2, 2, 2}}.depth_at(0.5, 0.5, 1);
  };
  EXPECT_NEAR(*depth_between(5120, 5200), 2.0 / (1.0 / 20.0 + 256.0 / 5200.0), 1e-9);
  EXPECT_TRUE(depth_between(5000, 5100)) << "2 %";
  EXPECT_FALSE(depth_between(5000, 5101));
  EXPECT_FALSE(depth_between(0, 5000));
}

TEST_F(ObjectSizeStudy, NamesTheTruthThatIsMissing) {
  fs::remove(folder_ / "truth" / "depth" / "left" / "0000000002.png");
  StudyTruth truth = this->truth();
  EXPECT_THAT(truth.images(2).error().message, HasSubstr("0000000002.png"));
  fs::remove(folder_ / "truth" / "objects.csv");
  EXPECT_FALSE(StudyTruth::open(folder_));
}

std::vector<StudyRun> two_recordings() {
  std::vector<StudyRun> runs{{"one", "1", {}}, {"two", "1", {}}, {"one", "default", {}}};
  for (int i = 0; i < 12; ++i) {
    StudyRow row{.frame = i, .object_id = 1, .distance_m = i < 6 ? 10.0 : 19.999, .height_px = 50};
    row.status = i == 0 ? BodyStatus::kLost : BodyStatus::kTracked;
    row.motion_m = i % 2 == 0 ? 0.3 : 0.4;
    row.depth_bias_m = -1.0;
    runs[0].rows.push_back(row);
  }
  runs[1].rows.push_back({.frame = 0, .object_id = 1, .distance_m = 20.0, .height_px = 15});
  return runs;
}

TEST(StudySummary, CollectsTheFramesOfABin) {
  const std::vector<StudyRun> runs = two_recordings();
  const StudyAxis& distance = study_axes()[0];
  const StudyBin bin = study_bin(runs, "1", "", distance, 1);  // [10, 20)
  EXPECT_EQ(bin.frames, 12U);
  EXPECT_EQ(bin.tracked, 11U);
  EXPECT_NEAR(*bin.shown(2), std::sqrt((0.09 + 0.16) / 2.0), 1e-12);
  EXPECT_NEAR(*bin.shown(4), 1.0, 1e-12) << "magnitudes";
  EXPECT_FALSE(bin.shown(0));
  EXPECT_EQ(study_bin(runs, "1", "", distance, 2).frames, 1U);
  EXPECT_EQ(study_bin(runs, "1", "two", distance, 1).frames, 0U);
  EXPECT_EQ(study_bin(runs, "default", "", distance, 1).frames, 0U);
  EXPECT_EQ(study_bin(runs, "1", "", study_axes()[1], 0).frames, 1U) << "height below 16 px";
}

TEST(StudySummary, ShowsNothingOfFewerThanTenMeasurements) {
  std::vector<StudyRun> runs = two_recordings();
  runs[0].rows.resize(10);
  EXPECT_TRUE(study_bin(runs, "1", "", study_axes()[0], 1).shown(2));
  runs[0].rows.resize(9);
  EXPECT_FALSE(study_bin(runs, "1", "", study_axes()[0], 1).shown(2));
  EXPECT_TRUE(study_bin(runs, "1", "", study_axes()[0], 1).errors[2].rmse());
}

TEST(StudySummary, PrintsATableOfTheBinsThatHaveFrames) {
  const std::string tables = study_tables(two_recordings());
  EXPECT_THAT(tables, HasSubstr("motion between frames, RMS [m]\n distance   frames        1  default\n"
                                "    10-20       12    0.354        -\n    20-30        1        -        -\n\n"));
}

TEST_F(ObjectSizeStudy, WritesFramesBinsAndPicture) {
  const std::vector<StudyRun> runs = two_recordings();
  ASSERT_TRUE(write_study_csv(runs, folder_));
  ASSERT_TRUE(write_study_plot(runs, folder_));
  EXPECT_TRUE(check_study_places(folder_)) << "another study may replace them";
  std::ifstream frames(folder_ / "frames.csv");
  std::string line;
  std::getline(frames, line);
  EXPECT_EQ(line,
            "recording,window,frame,object_id,distance_m,height_px,track_id,status,points,position_m,center_m,motion_m,"
            "motion_deg,depth_bias_m,depth_m,shape_m,wrong_points");
  std::getline(frames, line);
  EXPECT_EQ(line, "one,1,0,1,10.00000,50,0,lost,0,,,0.30000,,-1.00000,,,");
  std::ostringstream bins;
  bins << std::ifstream(folder_ / "bins.csv").rdbuf();
  EXPECT_THAT(bins.str(), HasSubstr("by,from,to,window,recording,frames,tracked,position_m"));
  EXPECT_THAT(bins.str(), HasSubstr("distance_m,10,20,1,all,12,11,,,0.35355,,1.00000,,,\n"));
  EXPECT_THAT(bins.str(), HasSubstr("height_px,0,16,1,two,1,0,,,,,,,,\n"));
  EXPECT_GT(fs::file_size(folder_ / "object_size.png"), 10000U);
  EXPECT_EQ(write_study_csv(runs, folder_ / "missing").error().code, ErrorCode::kIo);
  EXPECT_EQ(write_study_plot(runs, folder_ / "missing").error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace kinetrace::app
