// observations.bin: written beside a run, read back frame by frame, refused where it is damaged.
#include "kinetrace/recording/observations.hpp"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "kinetrace/recording/run_reader.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

constexpr int kFrames = 12;

class Observations : public ::testing::Test {
 protected:
  void SetUp() override {
    RecorderFixture fixture(recording_config(folder_.path() / "run"));
    ASSERT_TRUE(fixture.recorder) << fixture.recorder.error().message;
    SyntheticRunConfig config;
    config.frames = kFrames;
    config.objects = {{.track_id = 3}};
    ASSERT_TRUE(SyntheticRun(config).play(*fixture.recorder));
    RunSummary summary;
    summary.frames = kFrames;
    ASSERT_TRUE(fixture.recorder->finish(summary));
  }
  [[nodiscard]] recording::Run run() const {
    Result<recording::Run> run = read_run(folder_.path() / "run");
    EXPECT_TRUE(run) << run.error().message;
    return *run;
  }
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "run" / "observations.bin"; }

  TemporaryFolder folder_;
};

TEST_F(Observations, AreThoseOfTheFramesInOrder) {
  const recording::Run finished = run();
  Result<ObservationReader> reader = ObservationReader::open(finished);
  ASSERT_TRUE(reader) << reader.error().message;
  const StereoGeometry geometry = SyntheticRun::geometry();
  int frames = 0;
  std::int64_t records = 0;
  for (auto frame = reader->next_frame(); !frame->empty(); frame = reader->next_frame(), ++frames) {
    ASSERT_TRUE(frame) << frame.error().message;
    records += static_cast<std::int64_t>(frame->size());
    for (const Observation& seen : *frame) {
      ASSERT_EQ(seen.frame, frames);
      const Se3 T_world_body = seen.track_id == 0 ? Se3{} : SyntheticRun::T_world_obj(seen.track_id, frames);
      const Eigen::Vector3d p_world =
          T_world_body * SyntheticRun::point_position(seen.track_id, seen.point_id).cast<double>();
      const Eigen::Vector3d px = geometry.project(SyntheticRun::T_world_cam(frames).inverse() * p_world);
      EXPECT_NEAR(seen.u_left_px, px.x(), 1e-3);
      EXPECT_NEAR(seen.v_px, px.y(), 1e-3);
    }
  }
  EXPECT_EQ(frames, kFrames);
  EXPECT_EQ(finished.observation_rows, records);
}

TEST_F(Observations, OfAFinishedRunAreRefusedIfOneIsMissing) {
  const recording::Run finished = run();
  std::filesystem::resize_file(file(), std::filesystem::file_size(file()) - sizeof(Observation));
  const auto reader = ObservationReader::open(finished);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::kBadFormat);
  EXPECT_NE(reader.error().message.find("observations.bin"), std::string::npos);
}

TEST_F(Observations, OfAFinishedRunAreRefusedIfThereIsAPartOfOne) {
  const recording::Run finished = run();
  std::filesystem::resize_file(file(), std::filesystem::file_size(file()) - sizeof(Observation) / 2);
  const auto reader = ObservationReader::open(finished);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::kBadFormat);
  EXPECT_NE(reader.error().message.find(" records and a part of one, run.json says "), std::string::npos)
      << reader.error().message;
}

TEST_F(Observations, OfAKilledRunAreReadAsFarAsTheyGo) {
  recording::Run killed = run();
  killed.is_finished = false;
  std::filesystem::resize_file(file(), sizeof(Observation) * 5 + 7);
  Result<ObservationReader> reader = ObservationReader::open(killed);
  ASSERT_TRUE(reader) << reader.error().message;
  const auto frame = reader->next_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->size(), 4U);  // Behind the header.
  EXPECT_TRUE(reader->next_frame()->empty());
}

TEST_F(Observations, OfAnotherFileAreRefused) {
  const recording::Run finished = run();
  std::filesystem::copy_file(folder_.path() / "run" / "objects.csv", file(),
                             std::filesystem::copy_options::overwrite_existing);
  const auto reader = ObservationReader::open(finished);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::kBadFormat);
}

TEST_F(Observations, OfARunWithoutThemAreMissedWithTheKeyThatKeepsThem) {
  const recording::Run finished = run();
  std::filesystem::remove(file());
  const auto reader = ObservationReader::open(finished);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::kNotFound);
  EXPECT_NE(reader.error().message.find("output.observations"), std::string::npos);
}

}  // namespace
}  // namespace kinetrace::recording
