// Recordings that restart or have been cut: the camera is lost for one frame, and no object survives it.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "rendered_clip.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;

class CutInARecording : public ::testing::Test {
 protected:
  static constexpr int kFrames = 60;

  void run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run",   "--dataset",   clip_.dataset, "--segmentation", clip_.segmentation,
                                       "--out", out_.string(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = run_kinetrace(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::ifstream file(out_ / "run.json");
    counters_ = nlohmann::json::parse(file).at("counters");
  }
  /// Ids with rows in frames `first` to `end`.
  [[nodiscard]] std::set<int> ids(int first, int end) const {
    std::set<int> found;
    std::ifstream file(out_ / "objects.csv");
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      const int frame = std::stoi(line);
      const std::string after_time = line.substr(line.find(',', line.find(',') + 1) + 1);
      if (frame >= first && frame < end) {
        found.insert(std::stoi(after_time));
      }
    }
    return found;
  }
  /// Frame numbers from `first` on show the later half of the clip, last frame first.
  void turn_round_from(int first) const {
    const fs::path sequence = folder_.path() / "sequences/00";
    for (const fs::path& images :
         {sequence / "image_0", sequence / "image_1", folder_.path() / "left", folder_.path() / "right"}) {
      const auto file = [&](int frame) { return images / (stem_of(frame) + ".png"); };
      for (int frame = first; frame < kFrames; ++frame) {
        fs::rename(file(frame), images / ("was_" + std::to_string(frame)));
      }
      for (int frame = first; frame < kFrames; ++frame) {
        fs::rename(images / ("was_" + std::to_string(kFrames - 1 - (frame - first))), file(frame));
      }
    }
  }

  TempFolder folder_;
  RenderedClip clip_ = write_rendered_clip(folder_.path(), kFrames);
  fs::path out_ = folder_.path() / "run";
  nlohmann::json counters_;
};

TEST_F(CutInARecording, PlayedTwiceItLosesOneFrame) {
  run({"--loop", "2"});
  EXPECT_EQ(counters_.at("frames"), 2 * kFrames);
  EXPECT_EQ(counters_.at("background_lost_frames"), 1);
  const std::set<int> before = ids(0, kFrames);
  const std::set<int> after = ids(kFrames, 2 * kFrames);
  EXPECT_EQ(before.size(), 1U);
  EXPECT_EQ(after.size(), 1U);
  EXPECT_NE(before, after);
}

TEST_F(CutInARecording, CutItLosesOneFrameHoweverTheCameraMovesThen) {
  constexpr int kCut = 10;
  turn_round_from(kCut);
  run();
  EXPECT_EQ(counters_.at("background_lost_frames"), 1);
  const std::set<int> before = ids(0, kCut);
  const std::set<int> after = ids(kCut, kFrames);
  EXPECT_EQ(before.size(), 1U);
  EXPECT_EQ(after.size(), 1U);
  EXPECT_NE(before, after);
}

}  // namespace
}  // namespace kinetrace::test
