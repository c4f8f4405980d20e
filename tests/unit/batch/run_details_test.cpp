// Image names and gray values from a recorded run's models.
#include "run_details.hpp"

#include <filesystem>
#include <fstream>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "synthetic_run.hpp"

namespace kinetrace::batch {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 6;

class RunDetails : public ::testing::Test {
 protected:
  void SetUp() override {
    recording::SyntheticRunConfig config;
    config.frames = kFrames;
    config.objects = {{.track_id = 3, .points = 12}};
    config.name_prefix = "image_";
    ASSERT_TRUE(recording::record_all(recording::recording_config(folder_.path() / "run"), config));
    Result<recording::Run> run = recording::read_run(folder_.path() / "run");
    ASSERT_TRUE(run) << run.error().message;
    run_ = std::move(*run);
  }
  [[nodiscard]] fs::path file(const char* name) const { return run_.directory / name; }
  template <typename Details>
  static void expect_refused(const Details& details, const fs::path& path) {
    ASSERT_FALSE(details);
    EXPECT_EQ(details.error().code, ErrorCode::kBadFormat);
    EXPECT_NE(details.error().message.find(path.string() + ": is a "), std::string::npos) << details.error().message;
  }

  recording::TemporaryFolder folder_;
  recording::Run run_;
};

TEST_F(RunDetails, AreThoseOfTheModels) {
  EXPECT_TRUE(check_details(run_));
  const auto names = image_names(run_);
  ASSERT_TRUE(names) << names.error().message;
  EXPECT_EQ(names->size(), std::size_t{kFrames});
  EXPECT_TRUE(names->at(0).starts_with("image_"));
  const auto intensities = point_intensities(run_, 3);
  ASSERT_TRUE(intensities) << intensities.error().message;
  EXPECT_FALSE(intensities->empty());
}

TEST_F(RunDetails, AreEmptyWhereThereAreNone) {
  fs::remove_all(file("points"));
  fs::remove_all(file("colmap"));
  EXPECT_TRUE(check_details(run_));
  EXPECT_TRUE(image_names(run_).value().empty());
  EXPECT_TRUE(point_intensities(run_, 0).value().empty());
}

TEST_F(RunDetails, AreNotReadFromAPipeOrADevice) {
  for (const char* name : {"points/background.ply", "points/object_3_model.ply", "colmap/background/images.txt"}) {
    const fs::path kept = file(name).string() + ".kept";
    fs::rename(file(name), kept);
    ASSERT_EQ(::mkfifo(file(name).c_str(), 0600), 0);
    expect_refused(check_details(run_), file(name));
    fs::remove(file(name));
    fs::rename(kept, file(name));
  }
  fs::remove(file("points/background.ply"));
  fs::create_symlink("/dev/zero", file("points/background.ply"));
  expect_refused(point_intensities(run_, 0), file("points/background.ply"));
  fs::remove(file("colmap/background/images.txt"));
  fs::create_symlink("/dev/zero", file("colmap/background/images.txt"));
  expect_refused(image_names(run_), file("colmap/background/images.txt"));
}

TEST_F(RunDetails, TakeLittleMemoryWhateverIsInTheFiles) {
  std::ofstream(file("points/background.ply")).put('x');
  fs::resize_file(file("points/background.ply"), std::uintmax_t{1} << 26U);  // One line without an end.
  EXPECT_TRUE(point_intensities(run_, 0).value().empty());
}

}  // namespace
}  // namespace kinetrace::batch
