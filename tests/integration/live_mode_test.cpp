// Live mode from outside, on a recording that is played like a camera.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sched.h>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "service_manager.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class LiveMode : public ::testing::Test {
 protected:
  void SetUp() override { recording_.write(); }
  [[nodiscard]] std::vector<std::string> command(const char* name, const std::vector<std::string>& settings,
                                                 int loop) const {
    std::vector<std::string> all{"run",     "--dataset", recording_.dataset(), "--out", out(name).string(),
                                 "--quiet", "--loop",    std::to_string(loop)};
    for (const std::string& setting : settings) {
      all.insert(all.end(), {"--set", setting});
    }
    return all;
  }
  [[nodiscard]] ProgramResult run(const char* name, const std::vector<std::string>& settings, int loop = 1) const {
    return run_kinetrace(command(name, settings, loop));
  }
  [[nodiscard]] std::filesystem::path out(const char* name) const { return scratch_.path() / name; }
  [[nodiscard]] json report(const char* name) const {
    return json::parse(text_of(out(name) / "run.json"), nullptr, false);
  }
  [[nodiscard]] std::set<std::string> reasons(const char* name) const {
    std::set<std::string> names;
    const json all = report(name);
    for (const json& entry : all["health"]["reasons"]) {
      names.insert(entry["reason"].get<std::string>());
    }
    return names;
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
};

TEST_F(LiveMode, GivesTheSameResultsAsReplayWhenThereIsTime) {
  ASSERT_EQ(run("replay", {}).exit_code, 0);
  EXPECT_TRUE(report("replay")["live"].is_null());
  // One frame a second.
  const ProgramResult live = run("live", {"live.mode=on", "live.speed=0.1"});
  ASSERT_EQ(live.exit_code, 0) << live.err;
  EXPECT_EQ(live.err, "");
  for (const char* file : {"camera.tum", "objects.csv", "points/background.ply"}) {
    EXPECT_EQ(text_of(out("live") / file), text_of(out("replay") / file)) << file;
  }
  const json counted = report("live")["live"];
  EXPECT_EQ(counted["frames_left_out"], 0);
  EXPECT_EQ(counted["frames_late"], 0);
  EXPECT_EQ(counted["worst_shedding_level"], 0);
  EXPECT_EQ(counted["latency_ms"]["count"], recording_.frames);
  EXPECT_GT(counted["latency_ms"]["p50"], 0.0);
  EXPECT_GE(counted["latency_ms"]["p99"], counted["latency_ms"]["p50"]);
  EXPECT_EQ(report("live")["allocations_after_start"], report("replay")["allocations_after_start"]);
}

TEST_F(LiveMode, ShedsAndSaysSoWhereNoDeadlineCanBeMet) {
  constexpr int kLoop = 60;
  const ProgramResult result = run("live", {"live.mode=on", "live.speed=100", "live.deadline_ms=0.001"}, kLoop);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json counted = report("live")["live"];
  const std::int64_t processed = report("live")["frames"];
  EXPECT_EQ(processed + counted["frames_left_out"].get<std::int64_t>(), kLoop * recording_.frames);
  EXPECT_EQ(counted["frames_late"], processed);
  EXPECT_GE(counted["shedding_level"], 1);
  EXPECT_TRUE(reasons("live").contains("sheds_iterations"));
  EXPECT_THAT(result.err, HasSubstr("was degraded"));
  std::istringstream poses(text_of(out("live") / "camera.tum"));
  double last = -1.0;
  std::int64_t count = 0;
  for (std::string line; std::getline(poses, line);) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    const double time = std::stod(line);
    EXPECT_GT(time, last);
    last = time;
    ++count;
  }
  EXPECT_EQ(count, processed) << "what was processed was written";
}

TEST_F(LiveMode, DoesNotShedWhereThatIsNotWanted) {
  ASSERT_EQ(run("live", {"live.mode=on", "live.speed=100", "live.deadline_ms=0.001", "live.shed=false"}, 20).exit_code,
            0);
  EXPECT_EQ(report("live")["live"]["worst_shedding_level"], 0);
  EXPECT_GT(report("live")["live"]["frames_late"], 0);
  EXPECT_FALSE(reasons("live").contains("sheds_iterations"));
}

TEST_F(LiveMode, ASignalEndsItWithEverythingWritten) {
  Program program(command("live", {"live.mode=on"}, 1'000'000));
  while (text_of(out("live") / "camera.tum").empty()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  program.send(SIGTERM);
  EXPECT_EQ(program.wait().exit_code, 128 + SIGTERM);
  EXPECT_GT(report("live")["frames"], 0);
  EXPECT_EQ(report("live")["exit_status"], 128 + SIGTERM);
}

TEST_F(LiveMode, KilledItHasLostNothingThatWasFinal) {
  Program program(command("live", {"live.mode=on", "live.speed=10"}, 1'000'000));
  while (text_of(out("live") / "camera.tum").size() < 2000) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  program.send(SIGKILL);
  EXPECT_EQ(program.wait().exit_code, 128 + SIGKILL);
  const auto lines = [&](const char* file) {
    const std::string text = text_of(out("live") / file);
    EXPECT_TRUE(text.ends_with('\n')) << file << " ends within a line";
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("camera.tum"), lines("camera_kitti.txt"));
  // The next start reuses the folder.
  EXPECT_EQ(run("live", {}).exit_code, 0);
  EXPECT_EQ(lines("camera.tum"), recording_.frames);
}

/// Waits until `manager` has received a `wanted` message; fails with the last other message after two minutes.
::testing::AssertionResult is_received(const ServiceManager& manager,
                                       const std::function<bool(const std::string&)>& wanted) {
  const auto given_up_at = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  std::string last = "nothing";
  while (std::chrono::steady_clock::now() < given_up_at) {
    for (const std::string& text : manager.received()) {
      if (wanted(text)) {
        return ::testing::AssertionSuccess();
      }
      last = text;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return ::testing::AssertionFailure() << "last was " << last;
}

// The frame period lies midway, as a ratio, between the processing times with a tenth of a core and without a limit;
// later the limit is lifted. Frames are too large to be processed within one of the kernel's time slices.
TEST_F(LiveMode, StarvedOfProcessorItShedsAndReturnsWhenItCan) {
  const auto group = ControlGroup::of_processor(10);
  if (!group) {
    GTEST_SKIP() << "the kernel does not let this process make control groups";
  }
  recording_.width_px *= 3;
  recording_.height_px *= 3;
  recording_.write();
  constexpr int kPasses = 2;
  ASSERT_EQ(Program(command("starved", {}, kPasses), &*group).wait().exit_code, 0);
  ASSERT_EQ(run("free", {}, kPasses).exit_code, 0);
  const double starved_ms = report("starved")["frame_ms"]["median"];
  const double free_ms = report("free")["frame_ms"]["median"];
  const double period_ms = std::sqrt(starved_ms * free_ms);
  // Recovery needs 60 consecutive frames below 0.6 of the period, also on a machine that does other work.
  if (free_ms > 0.4 * period_ms) {
    GTEST_SKIP() << "a tenth of a core makes too little difference: " << starved_ms << " ms, without a limit "
                 << free_ms;
  }
  constexpr double kRecordedPeriod_ms = 100.0;
  const std::string speed = std::to_string(std::min(100.0, kRecordedPeriod_ms / period_ms));
  const ServiceManager manager;
  Program program(command("live", {"live.mode=on", "live.speed=" + speed}, 1'000'000), &*group);
  const auto says_shed = [](const std::string& text) { return text.find("sheds_") != std::string::npos; };
  EXPECT_TRUE(is_received(manager, says_shed));
  group->release_processor();
  // Other reasons may remain where the machine does other work: masks_missing, if the network is slow.
  EXPECT_TRUE(is_received(manager, [&](const std::string& text) { return !says_shed(text); }));
  program.send(SIGTERM);
  const ProgramResult result = program.wait();
  ASSERT_EQ(result.exit_code, 128 + SIGTERM) << result.err;
  const json counted = report("live")["live"];
  EXPECT_GE(counted["worst_shedding_level"], 1);
  EXPECT_EQ(counted["shedding_level"], 0);
  EXPECT_TRUE(reasons("live").contains("sheds_iterations"));
  EXPECT_EQ(allocations_after_start(report("live")), 0);
}

TEST_F(LiveMode, ABurstIsAnsweredWithItsNewestFrame) {
  // All frames of a pass are due within a millisecond, followed by a second without frames.
  std::ofstream times(recording_.sequence() / "times.txt");
  for (int i = 0; i < recording_.frames; ++i) {
    times << 1.5e-4 * i << "\n";
  }
  times.close();
  constexpr int kPasses = 4;
  const ProgramResult result = run("live", {"live.mode=on"}, kPasses);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json counted = report("live")["live"];
  const std::int64_t processed = report("live")["frames"];
  EXPECT_EQ(processed + counted["frames_left_out"].get<std::int64_t>(), kPasses * recording_.frames);
  EXPECT_GE(processed, 1);
  EXPECT_EQ(allocations_after_start(report("live")), 0);
}

TEST_F(LiveMode, CapturesWithRealtimePriorityWhereThatIsAllowed) {
  const std::vector<std::string> wanted{"live.mode=on", "live.realtime_priority=7"};
  Program program(command("live", wanted, 1'000'000));
  while (text_of(out("live") / "camera.tum").empty()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const int policy = sched_getscheduler(program.pid());
  program.send(SIGTERM);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 128 + SIGTERM);
  if (geteuid() == 0) {
    EXPECT_EQ(policy & ~SCHED_RESET_ON_FORK, SCHED_FIFO) << result.err;
  }
  EXPECT_EQ(result.err.find("realtime_priority") == std::string::npos, (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO);
}

TEST_F(LiveMode, ContinuesWithoutRealtimePriorityAndSaysHowToGetIt) {
  std::vector<std::string> program{"setpriv",   "--bounding-set", "-sys_nice",  "--inh-caps",
                                   "-sys_nice", "prlimit",        "--rtprio=0", KINETRACE_PROGRAM};
  const auto arguments = command("live", {"live.mode=on", "live.speed=10", "live.realtime_priority=7"}, 1);
  program.insert(program.end(), arguments.begin(), arguments.end());
  const std::string err = (scratch_.path() / "err").string();
  if (geteuid() != 0) {
    program.erase(program.begin(), program.begin() + 5);  // Other users have no such capability to drop.
  }
  EXPECT_EQ(await_end(start_program(program, (scratch_.path() / "out.txt").string(), err)), 0);
  EXPECT_THAT(text_of(err), HasSubstr("live.realtime_priority = 7"));
  EXPECT_THAT(text_of(err), HasSubstr("LimitRTPRIO=7"));
  EXPECT_EQ(report("live")["frames"].get<int>() + report("live")["live"]["frames_left_out"].get<int>(),
            recording_.frames);
}

TEST_F(LiveMode, ItsManagerHearsOfProgressAndTheEnd) {
  const ServiceManager manager;
  setenv("WATCHDOG_USEC", "400000", 1);
  ASSERT_EQ(run("live", {"live.mode=on", "live.speed=1"}).exit_code, 0);
  const std::vector<std::string> received = manager.received();
  ASSERT_GE(received.size(), 4U);
  EXPECT_EQ(received[0], "READY=1");
  EXPECT_EQ(received[1], "WATCHDOG=1");
  EXPECT_EQ(received.back(), "STOPPING=1");
}

TEST_F(LiveMode, SettingsThatCannotBeAreNamed) {
  for (const char* wrong :
       {"live.mode=sometimes", "live.speed=0", "live.deadline_ms=-1", "live.realtime_priority=100"}) {
    const ProgramResult result = run("live", {wrong});
    EXPECT_EQ(result.exit_code, 78) << wrong;
    EXPECT_THAT(result.err, HasSubstr(std::string(wrong).substr(0, std::string(wrong).find('=')))) << wrong;
  }
}

}  // namespace
}  // namespace kinetrace::test
