#include "kinetrace/core/files.hpp"

#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/core/input_file.hpp"
#include "temp_folder.hpp"

namespace kinetrace {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Unreachable, TellsWhatIsMissingFromWhatIsBarred) {
  const test::TempFolder folder;
  std::filesystem::create_symlink("loop", folder.path() / "loop");
  const std::filesystem::path none = folder.path() / "none";
  const Error missing = unreachable(none, "no such run").error();
  EXPECT_EQ(missing.code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.message, none.string() + ": no such run");
  EXPECT_EQ(unreachable(folder.file("a") + "/b", "no such run").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(unreachable(folder.path(), "no such file").error().message,
            folder.path().string() + ": is a folder; no such file");
  EXPECT_EQ(unreachable("/dev/null", "no such file").error().message, "/dev/null: is a device; no such file");
  const Error barred = unreachable(folder.path() / "loop" / "b", "no such run").error();
  EXPECT_EQ(barred.code, ErrorCode::kIo);
  EXPECT_THAT(barred.message, HasSubstr("loop/b: cannot be reached (Too many levels of symbolic links); check where"));
  const Error large = unreachable(folder.path() / std::string(300, 'x'), "no such run").error();
  EXPECT_THAT(large.message, HasSubstr("x: cannot be reached (File name too long); shorten it"));
}

TEST(CheckFolder, RefusesWhatCannotBeListed) {
  const test::TempFolder folder;
  EXPECT_TRUE(check_folder(folder.path(), "no such run"));
  std::ofstream(folder.file("file")) << "x";
  EXPECT_EQ(check_folder(folder.path() / "file", "no such run").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(check_folder(folder.path() / "none", "no such run").error().code, ErrorCode::kNotFound);
  // Root may list everything, another user must not.
  std::filesystem::permissions(folder.path(), std::filesystem::perms::none);
  const uid_t before = ::geteuid();
  constexpr uid_t kNobody = 65534;
  if (before == 0 && ::seteuid(kNobody) != 0) {
    GTEST_SKIP() << "no other user here";
  }
  const Status barred = check_folder(folder.path(), "no such run");
  const Result<InputFile> file = InputFile::open((folder.path() / "file").c_str());
  ASSERT_EQ(::seteuid(before), 0);
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
  ASSERT_FALSE(barred);
  EXPECT_EQ(barred.error().code, ErrorCode::kIo);
  EXPECT_EQ(barred.error().message,
            folder.path().string() + ": cannot be listed (Permission denied); check the permissions");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message,
            (folder.path() / "file").string() + ": cannot be opened (Permission denied); check its permissions");
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
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "what was staged is gone";
}

TEST(ReplaceFile, IsKnownBeforehandToHaveNoPlace) {
  const test::TempFolder folder;
  EXPECT_TRUE(check_replaceable(folder.path() / "new"));
  EXPECT_TRUE(check_replaceable("in_this_folder"));
  EXPECT_THAT(check_replaceable(folder.path()).error().message, HasSubstr("cannot be written (Is a directory)"));
  EXPECT_THAT(check_replaceable(folder.path() / "no" / "folder").error().message, HasSubstr("No such file"));
}

TEST(CheckSameKind, LetsAResultReplaceAnEarlierResultOnly) {
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "result";
  const FileKind kind{"result of mine", [](const std::filesystem::path& path) { return begins_with(path, "mine"); }};
  EXPECT_TRUE(check_same_kind(file, kind)) << "there is none";
  std::ofstream(file).flush();
  EXPECT_TRUE(check_same_kind(file, kind)) << "an empty one";
  EXPECT_TRUE(check_same_kind("/dev/null", kind));
  EXPECT_TRUE(check_same_kind(folder.path(), kind)) << "check_replaceable refuses it";
  std::ofstream(file) << "mine, too";
  EXPECT_TRUE(check_same_kind(file, kind));
  for (const char* other : {"min", "somebody's"}) {
    std::ofstream(file) << other;
    const Status refused = check_same_kind(file, kind);
    ASSERT_FALSE(refused) << other;
    EXPECT_EQ(refused.error().code, ErrorCode::kOccupied);
    EXPECT_EQ(refused.error().message,
              file.string() + ": is there already, and is no result of mine; name another place");
  }
}

TEST(BeginsWith, DoesNotWaitForAPipe) {
  const test::TempFolder folder;
  const std::filesystem::path pipe = folder.path() / "README.txt";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(begins_with(pipe, "mine"));
  EXPECT_FALSE(begins_with(folder.path() / "nothing", "mine"));
}

TEST(IsInside, KnowsFoldersByWhereTheyAre) {
  const test::TempFolder scratch;
  const std::filesystem::path folder = scratch.path() / "recording";
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_symlink(folder, scratch.path() / "link");
  for (const std::filesystem::path& inner :
       {folder, folder / "", folder / "rig.yaml", folder / "left" / "new" / "rig.yaml", scratch.path() / "link" / "a",
        scratch.path() / "new" / ".." / "recording" / "a"}) {
    EXPECT_TRUE(is_inside(inner, folder)) << inner;
    EXPECT_TRUE(is_inside(inner, folder / "")) << inner;
    EXPECT_TRUE(is_inside(inner, scratch.path() / "link")) << inner;
  }
  for (const std::filesystem::path& other :
       {scratch.path(), scratch.path() / "recording2", scratch.path() / "recording.yaml", folder / ".." / "a"}) {
    EXPECT_FALSE(is_inside(other, folder)) << other;
  }
  EXPECT_TRUE(is_inside("a/b", "a"));
  EXPECT_FALSE(is_inside("a", "a/b"));
}

TEST(ReplaceFile, LetsTwoProcessesReplaceTheSameFile) {
  const test::TempFolder folder;
  const std::filesystem::path file = folder.path() / "rig.yaml";
  const auto replace_often = [&file](char letter) {
    bool replaced = true;
    for (int i = 0; i < 100; ++i) {
      replaced = replace_file(file, std::string(10'000, letter)).has_value() && replaced;
    }
    return replaced;
  };
  const pid_t other = ::fork();
  if (other == 0) {
    ::_exit(replace_often('a') ? 0 : 1);
  }
  EXPECT_TRUE(replace_often('b'));
  int status = 0;
  ASSERT_EQ(::waitpid(other, &status, 0), other);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(text_of(file), std::string(10'000, text_of(file).front()));
}

TEST(ReplaceFile, DoesNotWaitForAReaderOfAPipe) {
  const test::TempFolder folder;
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(replace_file(pipe, "x").error().message, HasSubstr("pipe: cannot be written"));
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
