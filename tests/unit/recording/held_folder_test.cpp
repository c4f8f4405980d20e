#include "kinetrace/recording/held_folder.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "kinetrace/recording/run_recorder.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

class HeldRunFolder : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  fs::path directory_ = folder_.path() / "run";
};

TEST_F(HeldRunFolder, RefusesOtherRunsUntilItIsReleased) {
  Result<HeldFolder> held = HeldFolder::take(directory_);
  ASSERT_TRUE(held) << held.error().message;
  const Result<HeldFolder> second = HeldFolder::take(directory_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(second.error().message.find("another run"), std::string::npos) << second.error().message;
  EXPECT_FALSE(RunRecorder::check_folder(directory_));
  EXPECT_FALSE(RecorderFixture(recording_config(directory_)).recorder);
  held->release();
  EXPECT_TRUE(RecorderFixture(recording_config(directory_)).recorder);
}

TEST_F(HeldRunFolder, LeavesNothingBehindThatWasNotThere) {
  { EXPECT_TRUE(HeldFolder::take(directory_)); }
  EXPECT_FALSE(fs::exists(directory_));
  fs::create_directory(directory_);
  { EXPECT_TRUE(HeldFolder::take(directory_)); }
  EXPECT_TRUE(fs::exists(directory_));
}

TEST_F(HeldRunFolder, IsNoFolderOfOtherFiles) {
  fs::create_directory(directory_);
  std::ofstream(directory_ / "notes.txt") << "kept";
  EXPECT_FALSE(HeldFolder::take(directory_));
  EXPECT_TRUE(fs::exists(directory_ / "notes.txt"));
}

}  // namespace
}  // namespace kinetrace::recording
