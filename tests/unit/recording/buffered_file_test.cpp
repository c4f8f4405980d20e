#include "buffered_file.hpp"

#include <clocale>
#include <limits>
#include <string>
#include <sys/stat.h>
#include <vector>

#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

TEST(BufferedWriter, WritesNumbersAndTextThroughASmallBuffer) {
  const TemporaryFolder folder;
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  Result<BufferedWriter> out = BufferedWriter::create(folder.path() / "f", buffer);
  ASSERT_TRUE(out);
  std::string expected;
  for (int i = -500; i < 500; ++i) {
    out->integer(i).text(" ").fixed(i / 8.0, 3).text(" ").general(1e-7 * i, 3).text("\n");
    char line[64];
    std::snprintf(line, sizeof(line), "%d %.3f %.3g\n", i, i / 8.0, 1e-7 * i);
    expected += line;
  }
  ASSERT_TRUE(out->close());
  EXPECT_EQ(read_text(folder.path() / "f"), expected);
}

TEST(BufferedWriter, WritesTheLongestNumbersAndThoseThatAreNone) {
  const TemporaryFolder folder;
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  Result<BufferedWriter> out = BufferedWriter::create(folder.path() / "f", buffer);
  const double largest = std::numeric_limits<double>::max();
  for (int i = 0; i < 5; ++i) {
    out->fixed(-largest, 12).text("\n");
  }
  out->fixed(std::numeric_limits<double>::quiet_NaN(), 3).text("\n");
  ASSERT_TRUE(out->close());
  const std::vector<std::string> lines = read_lines(folder.path() / "f");
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(to_double(lines[4]), -largest);
  EXPECT_EQ(lines[5], "nan");
}

TEST(BufferedWriter, TakesBlocksLargerThanItsBuffer) {
  const TemporaryFolder folder;
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  Result<BufferedWriter> out = BufferedWriter::create(folder.path() / "f", buffer);
  const std::string large(10 * buffer.size() + 1, 'x');
  out->text("a").text(large).text("b");
  ASSERT_TRUE(out->close());
  EXPECT_EQ(read_text(folder.path() / "f"), "a" + large + "b");
}

TEST(BufferedWriter, RemembersThatTheDiskWasFull) {
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  Result<BufferedWriter> out = BufferedWriter::create("/dev/full", buffer);
  ASSERT_TRUE(out);
  out->text("x");
  EXPECT_TRUE(out->status()) << "nothing has been written yet";
  const Status flushed = out->flush();
  ASSERT_FALSE(flushed);
  EXPECT_EQ(flushed.error().code, ErrorCode::kIo);
  EXPECT_EQ(flushed.error().message,
            "cannot write /dev/full: No space left on device; free space or record to another folder");
  EXPECT_TRUE(out->failed());
  EXPECT_FALSE(out->close());
}

TEST(BufferedWriter, ReportsAFileThatCannotBeCreated) {
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  const Result<BufferedWriter> out = BufferedWriter::create("/nowhere/at/all", buffer);
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().message, "cannot create /nowhere/at/all: No such file or directory");
}

TEST(BufferedWriter, IgnoresEverythingWhenSwitchedOff) {
  BufferedWriter off;
  off.text("x").integer(3);
  EXPECT_FALSE(off.is_open());
  EXPECT_TRUE(off.flush());
  EXPECT_TRUE(off.close());
}

TEST(OpenFile, NeitherWaitsNorReadsFromAPipeOrADevice) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {pipe, std::filesystem::path("/dev/zero"), folder.path()}) {
    const Result<FileHandle> file = open_file(path, OpenMode::kRead);
    ASSERT_FALSE(file) << path;
    EXPECT_EQ(file.error().code, ErrorCode::kBadFormat);
    EXPECT_TRUE(file.error().message.starts_with(path.string() + ": is a ")) << file.error().message;
  }
  EXPECT_TRUE(open_file(folder.path(), OpenMode::kFolder));
  EXPECT_FALSE(open_file(pipe, OpenMode::kFolder));
}

TEST(ReadAt, ReportsAFileThatIsTooShort) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "short";
  std::vector<std::byte> buffer(BufferedWriter::kMinBufferBytes);
  Result<BufferedWriter> out = BufferedWriter::create(path, buffer);
  out->text("1234");
  ASSERT_TRUE(out->close());
  const Result<FileHandle> file = open_file(path, OpenMode::kRead);
  std::vector<std::byte> bytes(5);
  EXPECT_TRUE(read_at(*file, 0, std::span(bytes).first(4), path));
  const Status read = read_at(*file, 0, bytes, path);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace kinetrace::recording
