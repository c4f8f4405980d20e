#include "live/pipeline_thread.hpp"

#include <condition_variable>
#include <mutex>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 100.0, .fy_px = 100.0, .cx_px = 8.0, .cy_px = 4.0, .baseline_m = 0.1, .width_px = 16, .height_px = 8};
constexpr std::size_t kPixels = 128;  // Of an image.

/// Records processed frames; blocks processing while closed.
class Gate {
 public:
  Status process(const RectifiedPair& pair, std::int64_t exposed_ns) {
    std::unique_lock lock(mutex_);
    ++entered_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !closed_; });
    frames.push_back(pair.frame_index);
    names.emplace_back(pair.name);
    pixels.push_back(pair.left.at(3, 2) + pair.right.at(15, 7));
    exposed.push_back(exposed_ns);
    return fails_at == pair.frame_index ? fail(ErrorCode::kIo, "disk") : Status{};
  }
  void close() { set(true); }
  void open() { set(false); }
  /// Waits until processing of `count` frames has begun.
  void await_entered(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return entered_ >= count; });
  }

  std::vector<std::int64_t> frames;
  std::vector<std::string> names;
  std::vector<int> pixels;
  std::vector<std::int64_t> exposed;
  std::int64_t fails_at = -1;

 private:
  void set(bool closed) {
    const std::lock_guard lock(mutex_);
    closed_ = closed;
    changed_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  bool closed_ = false;
  int entered_ = 0;
};

class PipelineThreadTest : public ::testing::Test {
 protected:
  /// Its images and name are gone when this returns.
  Result<bool> offer(std::int64_t frame) {
    std::vector<std::uint8_t> left(kPixels, static_cast<std::uint8_t>(frame));
    std::vector<std::uint8_t> right(kPixels, static_cast<std::uint8_t>(100));
    std::string name = "frame " + std::to_string(frame);
    Result<bool> offered = thread_->offer({.frame_index = frame,
                                           .timestamp_ns = frame,
                                           .name = name,
                                           .left = {left.data(), 16, 8, 16},
                                           .right = {right.data(), 16, 8, 16},
                                           .geometry = kGeometry},
                                          1000 + frame);
    std::fill(left.begin(), left.end(), std::uint8_t{255});
    name.assign(name.size(), 'x');
    return offered;
  }

  Gate gate_;
  Arena arena_{PipelineThread::required_bytes(kGeometry)};
  std::unique_ptr<PipelineThread> thread_ =
      PipelineThread::create(
          kGeometry, [this](const RectifiedPair& pair, std::int64_t at) { return gate_.process(pair, at); }, [] {},
          arena_)
          .value();
};

TEST_F(PipelineThreadTest, ProcessesCopiesInOrder) {
  for (int frame = 0; frame < 5; ++frame) {
    EXPECT_EQ(offer(frame).value(), false);
    gate_.await_entered(frame + 1);
  }
  ASSERT_TRUE(thread_->finish());
  EXPECT_EQ(gate_.frames, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(gate_.names[2], "frame 2");
  EXPECT_EQ(gate_.pixels, (std::vector<int>{100, 101, 102, 103, 104}));
  EXPECT_EQ(gate_.exposed[4], 1004);
}

TEST_F(PipelineThreadTest, TheNewestWinsAndWhatIsLeftOutIsReported) {
  gate_.close();
  EXPECT_EQ(offer(0).value(), false);
  gate_.await_entered(1);
  EXPECT_EQ(offer(1).value(), false) << "it waits";
  EXPECT_EQ(offer(2).value(), true);
  EXPECT_EQ(offer(3).value(), true);
  gate_.open();
  ASSERT_TRUE(thread_->finish()) << "and processes what waits";
  EXPECT_EQ(gate_.frames, (std::vector<std::int64_t>{0, 3}));
  EXPECT_EQ(gate_.names.back(), "frame 3");
}

TEST_F(PipelineThreadTest, AFailureEndsProcessingAndIsReportedToBothSides) {
  gate_.fails_at = 1;
  EXPECT_EQ(offer(0).value(), false);
  gate_.await_entered(1);
  EXPECT_EQ(offer(1).value(), false);
  const Status finished = thread_->finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, "disk");
  const Result<bool> refused = offer(2);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_EQ(gate_.frames.back(), 1);
}

TEST_F(PipelineThreadTest, TakesExactlyTheBytesItAsksFor) {
  EXPECT_EQ(arena_.used_bytes(), PipelineThread::required_bytes(kGeometry));
  Arena too_small(PipelineThread::required_bytes(kGeometry) - 1);
  const auto refused = PipelineThread::create(
      kGeometry, [](const RectifiedPair&, std::int64_t) { return Status{}; }, [] {}, too_small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::app
