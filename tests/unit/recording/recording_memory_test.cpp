// Counts the recorder's allocations and watches its peak memory. Not built with sanitizers, which replace malloc.
#include <cstdint>
#include <sys/resource.h>

#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

std::int64_t peak_rss_kib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(RecordingMemory, RecordNeverAllocates) {
  ASSERT_TRUE(allocation_counting_available());
  const TemporaryFolder folder;
  RecordingConfig config = recording_config(folder.path());
  config.conversion_kib = 64;  // Buffers are written out many times.
  RecorderFixture fixture(config);
  ASSERT_TRUE(fixture.recorder);
  SyntheticRun run({.frames = 200,
                    .background_points = 100,
                    .objects = {{.track_id = 1}, {.track_id = 2000, .first_frame = 50, .last_frame = 120}},
                    .name_prefix = "a_name_longer_than_a_small_string_"});
  std::uint64_t allocations = 0;
  int results = 0;
  while (const FrameResult* result = run.next()) {
    const std::uint64_t before = allocation_counts().own;
    ASSERT_TRUE(fixture.recorder->record(*result));
    allocations += allocation_counts().own - before;
    ++results;
  }
  EXPECT_EQ(results, 204);
  EXPECT_EQ(allocations, 0U);
}

TEST(RecordingMemory, FinishingALongRunTakesNoMoreMemoryThanPlanned) {
#ifdef KINETRACE_EMULATED
  GTEST_SKIP() << "the emulator's own memory, for the code that it translates, counts too";
#endif
  const TemporaryFolder folder;
  const RecordingConfig config = recording_config(folder.path());
  RecorderFixture fixture(config);
  ASSERT_TRUE(fixture.recorder);
  SyntheticRun run({.frames = 2000, .background_points = 500, .objects = {{.track_id = 1, .points = 50}}});
  ASSERT_TRUE(run.play(*fixture.recorder));
  const auto spool = std::filesystem::file_size(folder.path() / ".spool/observations.bin");
  ASSERT_GT(spool, 20U * RunRecorder::required_bytes(config)) << "or the test shows nothing";
  const std::int64_t before_kib = peak_rss_kib();
  ASSERT_TRUE(fixture.recorder->finish({}));
  EXPECT_LT(peak_rss_kib() - before_kib, 1024);
}

}  // namespace
}  // namespace kinetrace::recording
