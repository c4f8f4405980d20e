#include "kinetrace/core/input_file.hpp"

#include <array>
#include <fstream>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace {
namespace {

using ::testing::HasSubstr;

class InputFiles : public ::testing::Test {
 protected:
  void write(const std::string& content) { std::ofstream(path_, std::ios::binary) << content; }
  static void expect_refused(const std::string& path, ErrorCode code, const char* what) {
    const Result<InputFile> file = InputFile::open(path.c_str());
    ASSERT_FALSE(file) << path;
    EXPECT_EQ(file.error().code, code);
    EXPECT_THAT(file.error().message, HasSubstr(path + ": " + what));
  }
  test::TempFolder folder_;
  std::string path_ = folder_.file("a");
};

TEST_F(InputFiles, AreReadFromAnyPlaceToTheirEnd) {
  write("0123456789");
  const InputFile file = InputFile::open(path_.c_str()).value();
  EXPECT_EQ(file.size_bytes(), 10U);
  std::array<std::uint8_t, 4> bytes{};
  EXPECT_EQ(file.read(3, bytes), 4U);
  EXPECT_EQ(bytes[0], '3');
  EXPECT_EQ(file.read(8, bytes), 2U);
  EXPECT_EQ(file.read(10, bytes), 0U);
}

TEST_F(InputFiles, RefuseWhateverWouldWaitOrNeverEnd) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  expect_refused(path_, ErrorCode::kBadFormat, "is a named pipe, not a file");
  expect_refused(folder_.path().string(), ErrorCode::kBadFormat, "is a folder, not a file");
  expect_refused("/dev/zero", ErrorCode::kBadFormat, "is a device, not a file");
  expect_refused(folder_.file("none"), ErrorCode::kNotFound, "no such file");
  expect_refused(folder_.file("b") + "/c", ErrorCode::kNotFound, "no such file");
}

TEST_F(InputFiles, AreReadWholeUpToALimit) {
  write("0123456789");
  EXPECT_EQ(InputFile::read_whole(path_, 10).value(), "0123456789");
  const Result<std::string> too_long = InputFile::read_whole(path_, 9);
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(too_long.error().message, HasSubstr(path_ + ": has 10 bytes; at most 9"));
  write("");
  EXPECT_EQ(InputFile::read_whole(path_, 9).value(), "");
}

}  // namespace
}  // namespace kinetrace
