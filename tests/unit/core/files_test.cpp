#include "kinetrace/core/files.hpp"

#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/resource.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(ReplaceFile, LeavesTheOldContentWhereTheNewOneDoesNotFit) {
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "evaluation.json";
  ASSERT_TRUE(replace_file(file, "old"));
  ASSERT_TRUE(replace_file(file, "older"));
  EXPECT_EQ(text_of(file), "older");
  const auto previous_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit previous{};
  ::getrlimit(RLIMIT_FSIZE, &previous);
  const rlimit limit{100, previous.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const Status replaced = replace_file(file, std::string(1000, 'n'));
  ::setrlimit(RLIMIT_FSIZE, &previous);
  std::signal(SIGXFSZ, previous_handler);
  ASSERT_FALSE(replaced);
  EXPECT_EQ(replaced.error().code, ErrorCode::kIo);
  EXPECT_THAT(replaced.error().message, HasSubstr(file.string() + ": cannot be written"));
  EXPECT_EQ(text_of(file), "older");
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".tmp"));
}

TEST(ReplaceFile, KeepsLinksAndWritesToDevices) {
  const test::TempFolder folder;
  std::ofstream(folder.file("real")) << "old";
  std::filesystem::create_symlink("real", folder.path() / "link");
  ASSERT_TRUE(replace_file(folder.path() / "link", "new"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path() / "link"));
  EXPECT_EQ(text_of(folder.path() / "real"), "new");
  EXPECT_TRUE(replace_file("/dev/null", "gone"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_FALSE(replace_file("/dev/full", "gone"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  EXPECT_EQ(replace_file(folder.path() / "no" / "folder", "x").error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace kinetrace
