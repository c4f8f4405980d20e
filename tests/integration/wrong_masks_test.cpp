// Masks of the other view or of another recording: reported, with the remedy.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "program.hpp"
#include "temp_folder.hpp"
#include "truth_run.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class WrongMasks : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path masks(const std::string& of) const { return world_.truth() / "masks" / of; }
  [[nodiscard]] ProgramResult run(const std::string& masks, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", "--quiet", "--dataset", "kitti-raw:" + world_.recording().string(),
                               "--segmentation", "masks:" + masks, "--out", (scratch_.path() / "run").string()});
    return run_kinetrace(more);
  }

  TempFolder scratch_;
  TruthRun world_{scratch_.path() / "sim"};
};

TEST_F(WrongMasks, NothingIsSaidOfGoodOnes) {
  const ProgramResult result = run(masks("detections_left").string() + "," + masks("detections_right").string());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, Not(HasSubstr("masks")));
}

TEST_F(WrongMasks, ExchangedViewsEndTheRun) {
  const std::string exchanged = masks("detections_right").string() + "," + masks("detections_left").string();
  const ProgramResult result = run(exchanged);
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, AllOf(HasSubstr(masks("detections_right").string()), HasSubstr("fit the right images")));
  const ProgramResult anyway = run(exchanged, {"--set", "input.unusable=warn"});
  EXPECT_EQ(anyway.exit_code, 0);
  EXPECT_THAT(anyway.err, AllOf(HasSubstr("fit the right images"), HasSubstr("masks_exchanged")));
}

TEST_F(WrongMasks, OfOtherImagesAreSaid) {
  const fs::path others = scratch_.path() / "others";
  fs::create_directories(others);
  // The masks of these images in reverse order.
  std::vector<fs::path> files(fs::directory_iterator(masks("detections_left")), {});
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size(); ++i) {
    fs::copy_file(files[i], others / files[files.size() - 1 - i].filename());
  }
  const ProgramResult result = run(others.string());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("belong to other images"), HasSubstr("masks_unrelated")));
}

}  // namespace
}  // namespace kinetrace::test
