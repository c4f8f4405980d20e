// Files of the MCAP writer, read back by an independent reader.
#include "kinetrace/recording/mcap_writer.hpp"

#include <csignal>
#include <fstream>
#include <sstream>
#include <sys/resource.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mcap_reader.hpp"
#include "temp_folder.hpp"

namespace kinetrace::recording::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

std::span<const std::byte> cdr(std::string_view text) {
  return std::as_bytes(std::span(text));
}

class Mcap : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path() const { return folder_.file("run.mcap"); }
  [[nodiscard]] std::string bytes() const {
    std::ostringstream content;
    content << std::ifstream(path(), std::ios::binary).rdbuf();
    return content.str();
  }
  [[nodiscard]] McapWriter make() const { return McapWriter::create(path(), "kinetrace test").value(); }

  /// Three topics of two types, five messages of different lengths, one of them empty.
  static void fill(McapWriter& writer) {
    ASSERT_EQ(writer.add_topic({"/tf", "tf2_msgs/msg/TFMessage", "transforms", {{"offered_qos_profiles", "- depth"}}})
                  .value(),
              0);
    ASSERT_EQ(writer.add_topic({"/odometry", "nav_msgs/msg/Odometry", "header", {}}).value(), 1);
    ASSERT_TRUE(writer.write(0, 1'000, 900, cdr("first")));
    ASSERT_TRUE(writer.write(1, 3'000'000'000'000, 2'999'999'999'999, cdr(std::string(300, 'x'))));
    ASSERT_EQ(writer.add_topic({"/tf_static", "tf2_msgs/msg/TFMessage", "not used", {}}).value(), 2);
    ASSERT_TRUE(writer.write(2, 500, -7, cdr("")));
    ASSERT_TRUE(writer.write(0, 2'000, 1'900, cdr("second")));
    ASSERT_TRUE(writer.write(1, 4'000, 3'900, cdr("last")));
  }
  static std::vector<ReadMessage> filled() {
    return {{0, 0, 1'000, 900, "first"},
            {1, 0, 3'000'000'000'000, 2'999'999'999'999, std::string(300, 'x')},
            {2, 0, 500, 0, ""},
            {0, 1, 2'000, 1'900, "second"},
            {1, 1, 4'000, 3'900, "last"}};
  }

 private:
  kinetrace::test::TempFolder folder_;
};

TEST_F(Mcap, HoldsTopicsTypesAndMessagesAsTheyCame) {
  McapWriter writer = make();
  fill(writer);
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(writer.counters().messages, 5U);
  EXPECT_EQ(writer.counters().bytes, bytes().size());

  const ReadMcap read = read_mcap(bytes());
  EXPECT_EQ(read.profile, "ros2");
  EXPECT_EQ(read.library, "kinetrace test");
  EXPECT_EQ(read.messages, filled());
  EXPECT_THAT(read.schemas, ElementsAre(Pair(1, ReadSchema{"tf2_msgs/msg/TFMessage", "ros2msg", "transforms"}),
                                        Pair(2, ReadSchema{"nav_msgs/msg/Odometry", "ros2msg", "header"})));
  EXPECT_THAT(read.channels, ElementsAre(Pair(0, ReadChannel{1, "/tf", "cdr", {{"offered_qos_profiles", "- depth"}}}),
                                         Pair(1, ReadChannel{2, "/odometry", "cdr", {}}),
                                         Pair(2, ReadChannel{1, "/tf_static", "cdr", {}})));
}

TEST_F(Mcap, HasAnIndexThatFindsEveryMessage) {
  McapWriter writer = make();
  fill(writer);
  ASSERT_TRUE(writer.finish());

  const std::string file = bytes();
  const ReadMcap read = read_mcap(file);
  ASSERT_TRUE(read.is_finished);
  EXPECT_EQ(read.summary_schemas, read.schemas);
  EXPECT_EQ(read.summary_channels, read.channels);
  ASSERT_TRUE(read.statistics);
  EXPECT_EQ(read.statistics->messages, 5U);
  EXPECT_EQ(read.statistics->chunks, 5U);
  EXPECT_EQ(read.statistics->first_time, 500U);
  EXPECT_EQ(read.statistics->last_time, 3'000'000'000'000U);
  EXPECT_THAT(read.statistics->by_channel, ElementsAre(Pair(0, 2), Pair(1, 2), Pair(2, 1)));
  // Schemas, channels, chunk indexes, statistics.
  EXPECT_THAT(read.group_starts, SizeIs(4));
  std::vector<ReadMessage> found;
  for (const ReadIndex& index : read.index) {
    ASSERT_THAT(index.message_indexes, SizeIs(1));
    found.push_back(read_indexed(file, index, index.message_indexes.begin()->first));
    EXPECT_EQ(index.start_time, found.back().log_time);
    EXPECT_EQ(index.end_time, found.back().log_time);
  }
  EXPECT_EQ(found, filled());
}

TEST_F(Mcap, CutAnywhereIsReadUpToItsLastWholeMessage) {
  std::vector<std::size_t> ends;  // Where the file ended after each message.
  {
    McapWriter writer = make();
    ASSERT_TRUE(writer.add_topic({"/tf", "tf2_msgs/msg/TFMessage", "transforms", {}}));
    for (const std::string_view text : {"one", "two and more", "", "four"}) {
      ASSERT_TRUE(writer.write(0, 1'000, 900, cdr(text)));
      // It is in the file already, while the writer is alive.
      ends.push_back(bytes().size());
    }
    ASSERT_TRUE(writer.finish());
  }
  const std::string file = bytes();
  const std::vector<ReadMessage> all = read_mcap(file).messages;
  ASSERT_THAT(all, SizeIs(4));
  // A message is complete with its chunk; the index entry behind it does not matter.
  constexpr std::size_t kIndexBytes = 9 + 2 + 4 + 16;
  for (std::size_t size = 8; size <= file.size(); ++size) {
    const auto whole = static_cast<std::size_t>(
        std::count_if(ends.begin(), ends.end(), [&](std::size_t end) { return end - kIndexBytes <= size; }));
    const ReadMcap read = read_mcap(file.substr(0, size));
    ASSERT_EQ(read.messages, std::vector<ReadMessage>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(whole)))
        << size << " of " << file.size() << " bytes";
    ASSERT_EQ(read.is_finished, size == file.size()) << size;
  }
}

TEST_F(Mcap, NoticesEveryFlippedBit) {
  McapWriter writer = make();
  fill(writer);
  const std::size_t messages_end = bytes().size();
  ASSERT_TRUE(writer.finish());
  const std::string file = bytes();
  const auto is_whole = [](const std::string& content) {
    try {
      return read_mcap(content).is_finished;
    } catch (const std::runtime_error&) {
      return false;
    }
  };
  ASSERT_TRUE(is_whole(file));
  for (std::size_t i = 0; i < file.size(); ++i) {
    std::string damaged = file;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    ASSERT_FALSE(is_whole(damaged)) << "byte " << i << ", messages end at " << messages_end;
  }
}

TEST_F(Mcap, HasNoIndexWhereTheDiskGivesBackAnotherLength) {
  // Lengths of the first record: beyond the end of the file, the largest number, and one that leads back to the
  // record's beginning.
  for (const std::uint64_t length : {std::uint64_t{1'000'000}, ~std::uint64_t{0}, ~std::uint64_t{0} - 8}) {
    std::filesystem::remove(path());
    McapWriter writer = make();
    fill(writer);
    std::fstream file(path(), std::ios::binary | std::ios::in | std::ios::out);
    constexpr std::streamoff kLengthAt = 8 + 1;
    file.seekp(kLengthAt);
    file.write(reinterpret_cast<const char*>(&length), sizeof length).flush();
    const Status finished = writer.finish();
    ASSERT_FALSE(finished) << length;
    EXPECT_EQ(finished.error().code, ErrorCode::kIo);
    EXPECT_THAT(finished.error().message, AllOf(HasSubstr(path()), HasSubstr("no index")));
  }
}

TEST_F(Mcap, WithoutAnyMessageIsAFileToo) {
  McapWriter writer = make();
  ASSERT_TRUE(writer.finish());
  const ReadMcap read = read_mcap(bytes());
  EXPECT_TRUE(read.is_finished);
  EXPECT_THAT(read.messages, IsEmpty());
  ASSERT_TRUE(read.statistics);
  EXPECT_EQ(read.statistics->messages, 0U);
  EXPECT_EQ(read.statistics->first_time, 0U);
}

TEST_F(Mcap, LeftUnfinishedIsReadableAndSaysSo) {
  {
    McapWriter writer = make();
    fill(writer);
  }
  const ReadMcap read = read_mcap(bytes());
  EXPECT_EQ(read.messages, filled());
  EXPECT_FALSE(read.is_finished);
}

TEST_F(Mcap, KeepsFilesThatExist) {
  std::ofstream(path()) << "precious";
  const auto writer = McapWriter::create(path(), "kinetrace test");
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().code, ErrorCode::kIo);
  EXPECT_THAT(writer.error().message, AllOf(HasSubstr(path()), HasSubstr("name a new file")));
  EXPECT_EQ(bytes(), "precious");
}

TEST_F(Mcap, RefusesMessagesOfNoTopicAndAfterTheEnd) {
  McapWriter writer = make();
  EXPECT_EQ(writer.write(0, 1, 1, cdr("x")).error().code, ErrorCode::kInvalidArgument);
  ASSERT_TRUE(writer.add_topic({"/tf", "tf2_msgs/msg/TFMessage", "transforms", {}}));
  ASSERT_TRUE(writer.write(0, 1, 1, cdr("x")));
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(writer.write(0, 1, 1, cdr("y")).error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(writer.finish());
  EXPECT_THAT(read_mcap(bytes()).messages, SizeIs(1));
}

/// Files of this process may not grow beyond `bytes` while it exists.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::size_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

TEST_F(Mcap, EndsWithTheLastWholeMessageOnAFullDisk) {
  McapWriter writer = make();
  ASSERT_TRUE(writer.add_topic({"/tf", "tf2_msgs/msg/TFMessage", "transforms", {}}));
  ASSERT_TRUE(writer.write(0, 1'000, 900, cdr("fits")));
  const std::size_t whole = bytes().size();
  Status refused;
  {
    const FileSizeLimit limit(whole + 50);
    refused = writer.write(0, 2'000, 1'900, cdr(std::string(100, 'x')));
  }
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr(path()), HasSubstr("free space")));
  EXPECT_EQ(bytes().size(), whole);
  // There would be room again, but a gap in the recording is worse than its end.
  EXPECT_EQ(writer.write(0, 3'000, 2'900, cdr("late")).error().message, refused.error().message);
  EXPECT_EQ(writer.add_topic({"/a", "b", "c", {}}).error().message, refused.error().message);
  EXPECT_EQ(writer.finish().error().message, refused.error().message);
  EXPECT_THAT(read_mcap(bytes()).messages, SizeIs(1));
}

TEST_F(Mcap, WhoseIndexDoesNotFitKeepsItsMessages) {
  McapWriter writer = make();
  fill(writer);
  const std::size_t whole = bytes().size();
  {
    const FileSizeLimit limit(whole + 100);
    EXPECT_EQ(writer.finish().error().code, ErrorCode::kIo);
  }
  EXPECT_EQ(bytes().size(), whole);
  EXPECT_EQ(read_mcap(bytes()).messages, filled());
}

TEST_F(Mcap, IndexesMoreMessagesThanGoIntoOneWrite) {
  constexpr std::size_t kMessages = 2'000;  // Of about 80 bytes in the index.
  McapWriter writer = make();
  ASSERT_TRUE(writer.add_topic({"/tf", "tf2_msgs/msg/TFMessage", "transforms", {}}));
  for (std::size_t i = 0; i < kMessages; ++i) {
    ASSERT_TRUE(writer.write(0, static_cast<std::int64_t>(i), 0, cdr("x")));
  }
  ASSERT_TRUE(writer.finish());
  const std::string file = bytes();
  const ReadMcap read = read_mcap(file);
  ASSERT_TRUE(read.is_finished);
  ASSERT_THAT(read.index, SizeIs(kMessages));
  EXPECT_EQ(read_indexed(file, read.index.back(), 0).log_time, kMessages - 1);
}

}  // namespace
}  // namespace kinetrace::recording::test
