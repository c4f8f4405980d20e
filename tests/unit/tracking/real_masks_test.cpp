// Masks of real street scenes, degraded like a network's: shuffled labels, misses, border noise. Without features, so
// that masks are predicted only by their last motion.
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
namespace {

/// Frames in which each track covered most of a true instance.
using FramesOfTrack = std::map<std::uint32_t, int>;

class RealMasks : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* root = std::getenv("KINETRACE_DATA");
    if (root == nullptr || !std::filesystem::is_directory(std::filesystem::path(root) / "masks" / GetParam())) {
      GTEST_SKIP() << "KINETRACE_DATA does not name a folder of real recordings";
    }
    folder_ = std::filesystem::path(root) / "masks" / GetParam();
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "instances_left")) {
      stems_.push_back(entry.path().stem().string());
    }
    std::sort(stems_.begin(), stems_.end());
    const Result<imaging::ImageInfo> info = imaging::read_image_info(true_file(stems_.front()).c_str());
    ASSERT_TRUE(info.has_value());
    geometry_.width_px = info->width;
    geometry_.height_px = info->height;
    truth_.resize(static_cast<std::size_t>(info->width) * static_cast<std::size_t>(info->height));
  }
  [[nodiscard]] std::string true_file(const std::string& stem) const {
    return (folder_ / "instances_left" / (stem + ".png")).string();
  }

  [[nodiscard]] ImageView<std::uint16_t> truth() {
    return {truth_.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
  }

  /// Adds one frame to the tally of each true instance of at least 200 px.
  void score(const TrackFrame& frame, std::map<int, FramesOfTrack>& tally, std::map<int, int>& frames_seen) {
    std::map<int, int> area;
    std::map<std::pair<int, std::uint32_t>, int> shared;
    for (int y = 0; y < geometry_.height_px; ++y) {
      const std::uint16_t* truth_row = truth().row(y);
      for (int x = 0; x < geometry_.width_px; ++x) {
        const int instance = truth_row[x];
        if (instance == 0) {
          continue;
        }
        ++area[instance];
        for (const Track& track : frame.tracks) {
          if (frame.left_labels.at(x, y) == track.label()) {
            ++shared[{instance, track.id}];
          }
        }
      }
    }
    for (const auto& [instance, pixels] : area) {
      if (pixels < 200) {
        continue;
      }
      ++frames_seen[instance];
      for (const Track& track : frame.tracks) {
        tally[instance][track.id] += 2 * shared[{instance, track.id}] > pixels ? 1 : 0;
      }
    }
  }

  std::filesystem::path folder_;
  std::vector<std::string> stems_;
  StereoGeometry geometry_ = {
      .fx_px = 700.0, .fy_px = 700.0, .cx_px = 600.0, .cy_px = 180.0, .baseline_m = 0.5, .width_px = 0, .height_px = 0};
  std::vector<std::uint16_t> truth_;
};

TEST_P(RealMasks, KeepTheirIds) {
  segmentation::SegmentationConfig config;
  config.mode = segmentation::SegmentationMode::kMasks;
  config.left_dir = (folder_ / "detections_left").string();
  Arena arena(segmentation::required_bytes(config, geometry_, 1) +
              StereoTracker::required_bytes({}, geometry_.width_px, geometry_.height_px));
  const auto segmenter = segmentation::make_segmenter(config, geometry_, 1, arena).value();
  StereoTracker tracker = StereoTracker::create({}, geometry_.width_px, geometry_.height_px, arena).value();
  Arena reader_arena(std::size_t{16} << 20U);
  auto reader = imaging::ImageReader::create({}, reader_arena).value();

  std::map<int, FramesOfTrack> tally;
  std::map<int, int> frames_seen;
  for (std::size_t i = 0; i < stems_.size(); ++i) {
    segmentation::SegmentationInput input;
    input.pair.frame_index = static_cast<std::int64_t>(i);
    input.pair.name = stems_[i];
    segmenter->load(input.pair, {});
    const DetectionFrame detections = segmenter->process(input).value();
    const TrackFrame frame = tracker.process(static_cast<std::int64_t>(i) * kUsualInterval_ns, detections, {}).value();
    ASSERT_TRUE(reader.read_gray16(true_file(stems_[i]).c_str(), truth()).has_value());
    score(frame, tally, frames_seen);
  }

  EXPECT_FALSE(frames_seen.empty());
  for (const auto& [instance, frames] : frames_seen) {
    int best = 0;
    int others = 0;
    for (const auto& [id, count] : tally[instance]) {
      others += std::min(best, count);
      best = std::max(best, count);
    }
    EXPECT_GE(best, 0.9 * frames - 1.0) << "instance " << instance;  // a track cannot precede its first detection
    EXPECT_EQ(others, 0) << "instance " << instance << " changed its id";
  }
  EXPECT_EQ(segmenter->counters().frames_missing, 0U);
}

INSTANTIATE_TEST_SUITE_P(Clips, RealMasks, ::testing::Values("kitti_raw_0039", "ramp", "oncoming"),
                         [](const auto& clip) { return std::string(clip.param); });

}  // namespace
}  // namespace kinetrace::tracking
