#include "external_sort.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

struct Item {
  std::uint32_t key = 0;
  std::uint32_t payload = 0;
  std::uint32_t more = 0;
};
constexpr auto kByKey = [](const Item& a, const Item& b) {
  return std::tie(a.key, a.payload) < std::tie(b.key, b.payload);
};
constexpr std::size_t kMemoryBytes = 32768;
constexpr std::size_t kItemsInMemory = kMemoryBytes / sizeof(Item);

/// Sorts `count` random items on disk within 32 KiB and compares with std::sort.
void expect_sorted(std::size_t count) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "items.bin";
  std::mt19937 random(static_cast<std::uint32_t>(count));
  std::vector<Item> items;
  for (std::uint32_t i = 0; i < count; ++i) {
    items.push_back({static_cast<std::uint32_t>(random() % 1000), i, ~i});
  }
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(items.data()), static_cast<std::streamsize>(items.size() * sizeof(Item)));
  Arena arena(kMemoryBytes);
  const Status sorted = sort_file<Item>(path, arena.take<std::byte>(kMemoryBytes), kByKey);
  ASSERT_TRUE(sorted) << sorted.error().message;
  std::sort(items.begin(), items.end(), kByKey);
  const std::string data = read_text(path);
  ASSERT_EQ(data.size(), items.size() * sizeof(Item));
  EXPECT_TRUE(std::equal(data.begin(), data.end(), reinterpret_cast<const char*>(items.data())));
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".merge"));
}

TEST(ExternalSort, SortsNothingAndOne) {
  expect_sorted(0);
  expect_sorted(1);
}
TEST(ExternalSort, SortsWhatJustFitsMemoryAndOneMore) {
  expect_sorted(kItemsInMemory);
  expect_sorted(kItemsInMemory + 1);
}
TEST(ExternalSort, MergesOnceUpToFifteenRunsAndTwiceBeyond) {
  expect_sorted(15 * kItemsInMemory);
  expect_sorted(15 * kItemsInMemory + 1);
}
TEST(ExternalSort, SortsAHundredTimesItsMemory) {
  expect_sorted(100 * kItemsInMemory + 77);
}

TEST(ExternalSort, NamesTheMissingFile) {
  const TemporaryFolder folder;
  Arena arena(kMemoryBytes);
  const Status sorted = sort_file<Item>(folder.path() / "absent.bin", arena.take<std::byte>(kMemoryBytes), kByKey);
  ASSERT_FALSE(sorted);
  EXPECT_EQ(sorted.error().code, ErrorCode::kIo);
  EXPECT_NE(sorted.error().message.find("absent.bin"), std::string::npos);
}

}  // namespace
}  // namespace kinetrace::recording
