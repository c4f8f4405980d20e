// `kinetrace study`, from outside: what it refuses before it reads any image.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "program.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;

class StudyCommand : public ::testing::TestWithParam<const char*> {
 protected:
  StudyCommand() { fs::create_directories(recording_ / "truth"); }
  [[nodiscard]] static ProgramResult study(const std::vector<fs::path>& recordings, const fs::path& out) {
    std::vector<std::string> arguments{"study", GetParam(), "--out", out.string()};
    for (const fs::path& recording : recordings) {
      arguments.push_back(recording.string());
    }
    return run_kinetrace(arguments);
  }

  TempFolder scratch_;
  fs::path recording_ = scratch_.path() / "recording";
  fs::path out_ = scratch_.path() / "out";
};
INSTANTIATE_TEST_SUITE_P(Both, StudyCommand, ::testing::Values("object-size", "limit"),
                         [](const auto& study) { return study.index == 0 ? "ObjectSize" : "Limit"; });

TEST_P(StudyCommand, CountsNoRecordingTwice) {
  fs::create_directory_symlink(recording_, scratch_.path() / "link");
  for (const fs::path& again : {recording_, recording_ / "truth" / "..", scratch_.path() / "link"}) {
    expect_refusal(study({recording_, again}, out_), kUsage, again.string() + ": is the recording");
  }
  EXPECT_FALSE(fs::exists(out_));
}

TEST_P(StudyCommand, StaysOutOfItsRecordings) {
  const fs::path other = scratch_.path() / "other";
  fs::create_directories(other);
  for (const fs::path& out : {recording_, recording_ / "study", other}) {
    expect_refusal(study({other, recording_}, out), kCannotCreate, "lies in the recording");
  }
  EXPECT_FALSE(fs::exists(recording_ / "study"));
}

TEST_P(StudyCommand, ReplacesNothingButAnEarlierStudy) {
  const bool is_limit = std::string(GetParam()) == "limit";
  const std::vector<std::string> names = is_limit
                                             ? std::vector<std::string>{"limit.csv", "limit.png"}
                                             : std::vector<std::string>{"frames.csv", "bins.csv", "object_size.png"};
  fs::create_directories(out_);
  for (const std::string& name : names) {
    std::ofstream(out_ / name) << "precious";
    expect_refusal(study({recording_}, out_), kCannotCreate, name);
    EXPECT_EQ(text_of(out_ / name), "precious");
    fs::remove(out_ / name);
  }
}

}  // namespace
}  // namespace kinetrace::test
