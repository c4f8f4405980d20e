// A run with masks from another process.
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/imaging/png_writer.hpp"
#include "kinetrace/publishing/mask_exchange.hpp"
#include "program.hpp"
#include "temp_folder.hpp"
#include "test_domain.hpp"
#include "truth_run.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string content_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class MasksOverDds : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    world_ = new TruthRun(shared_->path() / "sim");
  }
  static void TearDownTestSuite() {
    delete world_;
    delete shared_;
  }

  MasksOverDds() { std::ofstream(network_) << "dds:\n  domain: " << domain_ << "\n  device: rig\n"; }

  [[nodiscard]] static fs::path masks(const char* side) {
    return world_->truth() / "masks" / (std::string("detections_") + side);
  }
  [[nodiscard]] static std::string both_sides() { return masks("left").string() + "," + masks("right").string(); }
  [[nodiscard]] fs::path run_folder(const char* name) const { return scratch_.path() / name; }
  [[nodiscard]] ProgramResult run(const char* name, std::vector<std::string> more) const {
    more.insert(more.begin(), {"run", "--dataset", "kitti-raw:" + world_->recording().string(), "--out",
                               run_folder(name).string(), "--quiet"});
    return run_kinetrace(more);
  }
  /// Over DDS, with masks of both views; the time-out allows for a busy machine.
  [[nodiscard]] ProgramResult run_over_dds(const char* name, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"--segmentation", "dds", "--publish", network_, "--set", "segmentation.dds.right=true",
                               "--set", "segmentation.dds.timeout_ms=30000"});
    return run(name, more);
  }
  [[nodiscard]] json counters(const char* name) const {
    return json::parse(content_of(run_folder(name) / "run.json")).at("counters");
  }

  static inline TempFolder* shared_ = nullptr;
  static inline TruthRun* world_ = nullptr;
  TempFolder scratch_;
  int domain_ = test_domain();
  std::string network_ = scratch_.file("dds.yaml");
};

TEST_F(MasksOverDds, GiveTheSameResultAsTheFilesTheyAreMadeFrom) {
  ASSERT_EQ(run("files", {"--segmentation", "masks:" + both_sides()}).exit_code, 0);
  Program client({"masks", both_sides(), "--publish", network_, "--quiet"});
  const ProgramResult over_dds = run_over_dds("dds");
  client.send(SIGTERM);
  const ProgramResult sent = client.wait();
  ASSERT_EQ(over_dds.exit_code, 0) << over_dds.err;
  EXPECT_EQ(sent.exit_code, 0) << sent.err;

  EXPECT_EQ(counters("dds").at("mask_frames_taken"), TruthRun::kFrames);
  EXPECT_EQ(counters("dds").at("mask_frames_timed_out"), 0);
  EXPECT_EQ(counters("dds").at("mask_messages_invalid"), 0);
  for (const char* file : {"objects.csv", "camera.tum", "label_02.txt", "mots.txt"}) {
    const std::string expected = content_of(run_folder("files") / file);
    ASSERT_GT(expected.size(), 200U) << file;
    EXPECT_EQ(content_of(run_folder("dds") / file), expected) << file;
  }
}

TEST_F(MasksOverDds, FramesWithoutMasksAreCountedAndTracksContinue) {
  // The client lacks frames 4 and 5.
  const fs::path some = scratch_.path() / "some";
  fs::copy(masks("left"), some);
  fs::remove(some / "0000000004.png");
  fs::remove(some / "0000000005.png");
  Program client({"masks", some.string(), "--publish", network_, "--quiet"});
  const ProgramResult result =
      run("dds", {"--segmentation", "dds", "--publish", network_, "--set", "segmentation.dds.timeout_ms=3000"});
  client.send(SIGINT);
  EXPECT_EQ(client.wait().exit_code, 0);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(counters("dds").at("mask_frames_timed_out"), 2);
  EXPECT_EQ(counters("dds").at("mask_frames_taken"), TruthRun::kFrames - 2);
  EXPECT_EQ(counters("dds").at("detection_frames_missing"), 2);
  EXPECT_THAT(result.err, HasSubstr("without masks in 2 frames: 2 waited in vain"));
  // Frame 5 has propagated masks.
  EXPECT_THAT(content_of(run_folder("dds") / "mots.txt"), HasSubstr("\n5 "));
}

TEST_F(MasksOverDds, OfAnotherSizeAreRefusedAndCounted) {
  const fs::path small = scratch_.path() / "small";
  fs::create_directories(small);
  const std::vector<std::uint16_t> pixels(std::size_t{64} * 48, 1001);
  for (const char* name : {"0.png", "1.png"}) {
    ASSERT_TRUE(imaging::write_png_gray16((small / name).c_str(), {pixels.data(), 64, 48, 64}));
  }
  Program client({"masks", small.string(), "--publish", network_, "--quiet"});
  const ProgramResult result = run("dds", {"--segmentation", "dds", "--publish", network_, "--frames", "2", "--set",
                                           "segmentation.dds.timeout_ms=30000"});
  client.send(SIGINT);
  EXPECT_EQ(client.wait().exit_code, 0);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(counters("dds").at("mask_messages_invalid"), 2);
  EXPECT_THAT(result.err, HasSubstr("messages with masks were refused"));
}

TEST_F(MasksOverDds, ADamagedFileCostsTheMasksOfItsFrameAlone) {
  const fs::path some = scratch_.path() / "some";
  fs::copy(masks("left"), some);
  fs::resize_file(some / "0000000004.png", 100);
  fs::remove(some / "0000000005.png");
  fs::create_directories(some / "0000000005.png");
  fs::remove(some / "0000000006.png");
  ASSERT_EQ(mkfifo((some / "0000000006.png").c_str(), 0600), 0);
  Program client({"masks", some.string(), "--publish", network_});
  const ProgramResult result =
      run("dds", {"--segmentation", "dds", "--publish", network_, "--set", "segmentation.dds.timeout_ms=3000"});
  client.send(SIGTERM);
  const ProgramResult sent = client.wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(sent.exit_code, 0) << sent.err;
  EXPECT_EQ(counters("dds").at("mask_frames_taken"), TruthRun::kFrames - 3);
  EXPECT_THAT(sent.err, AllOf(HasSubstr("warning: "), HasSubstr("0000000004.png"), Not(HasSubstr("0000000005.png")),
                              HasSubstr("masks sent for 7 frames, not for 3 others")));
}

TEST_F(MasksOverDds, ClientFailsWhereNoMasksCouldBeSentAtAll) {
  const fs::path damaged = scratch_.path() / "damaged";
  fs::create_directories(damaged);
  for (const char* name : {"0.png", "1.png"}) {
    std::ofstream(damaged / name) << "x";
  }
  Program client({"masks", damaged.string(), "--publish", network_, "--quiet"});
  const ProgramResult result = run("dds", {"--segmentation", "dds", "--publish", network_, "--frames", "2", "--set",
                                           "segmentation.dds.timeout_ms=1000"});
  client.send(SIGTERM);
  const ProgramResult sent = client.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(sent.exit_code, 65) << sent.err;
  EXPECT_THAT(sent.err, HasSubstr("error: " + (damaged / "0.png").string()));
}

/// Answers every request with the image of `answer`, while it exists.
class ScriptedMaskServer {
 public:
  using Answer = std::function<publishing::MaskSender::Image(const MaskRequest&)>;
  ScriptedMaskServer(int domain, Answer answer) : answer_(std::move(answer)) {
    publishing::PublishConfig config;
    config.domain = domain;
    link_ = publishing::Link::create(config).value();
    thread_ = std::thread([this] {
      publishing::MaskSender sender(*link_, "rig");
      while (!ends_) {
        if (const auto request = sender.take_request(); request && *request) {
          EXPECT_TRUE(sender.send(answer_(**request)));
        }
        link_->wait(10'000'000);
      }
    });
  }
  ScriptedMaskServer(const ScriptedMaskServer&) = delete;
  ScriptedMaskServer& operator=(const ScriptedMaskServer&) = delete;
  ~ScriptedMaskServer() {
    ends_ = true;
    thread_.join();
  }

 private:
  Answer answer_;
  std::unique_ptr<publishing::Link> link_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

TEST_F(MasksOverDds, BadMessagesOfAnotherSenderSpoilNothing) {
  const ScriptedMaskServer saboteur(domain_, [](const MaskRequest& request) {
    return publishing::MaskSender::Image{
        .frame_index = request.frame_index, .timestamp_ns = request.timestamp_ns, .width_px = 64, .height_px = 48};
  });
  Program client({"masks", masks("left").string(), "--publish", network_, "--quiet"});
  // The run waits for any sender, and the faulty one exists already.
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const ProgramResult result =
      run("dds", {"--segmentation", "dds", "--publish", network_, "--set", "segmentation.dds.timeout_ms=5000"});
  client.send(SIGTERM);
  EXPECT_EQ(client.wait().exit_code, 0);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(counters("dds").at("mask_messages_invalid"), 0);
  // The first frame may time out before both are discovered.
  EXPECT_GE(counters("dds").at("mask_frames_taken"), TruthRun::kFrames - 1);
}

TEST_F(MasksOverDds, MasksOfAnotherRunAreRefusedAndReported) {
  const ScriptedMaskServer of_another_run(domain_, [](const MaskRequest& request) {
    return publishing::MaskSender::Image{.frame_index = request.frame_index,
                                         .timestamp_ns = request.timestamp_ns - 1,
                                         .width_px = static_cast<int>(request.width_px),
                                         .height_px = static_cast<int>(request.height_px)};
  });
  const ProgramResult result =
      run("dds", {"--segmentation", "dds", "--publish", network_, "--set", "segmentation.dds.timeout_ms=500"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(counters("dds").at("mask_frames_taken"), 0);
  EXPECT_GT(counters("dds").at("mask_messages_of_other_run"), 0);
  EXPECT_THAT(result.err, AllOf(HasSubstr("messages with masks are refused: their time is not that of the frame"),
                                HasSubstr("dds.device")));
}

TEST_F(MasksOverDds, ARunWithoutASenderContinuesAndReportsIt) {
  const ProgramResult result = run_over_dds("dds");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("no process sends masks"), HasSubstr("in 10 without a sender")));
  EXPECT_EQ(counters("dds").at("mask_frames_without_sender"), TruthRun::kFrames);
}

TEST_F(MasksOverDds, NeedANetworkToComeOver) {
  const ProgramResult result = run("dds", {"--segmentation", "dds"});
  EXPECT_EQ(result.exit_code, 64);
  EXPECT_THAT(result.err, HasSubstr("segmentation dds needs --publish FILE"));
}

TEST_F(MasksOverDds, ClientNamesWhatIsWrongWithItsFolder) {
  const ProgramResult missing = run_kinetrace({"masks", run_folder("nowhere").string(), "--publish", network_});
  EXPECT_EQ(missing.exit_code, 66);
  EXPECT_THAT(missing.err, HasSubstr("nowhere: no such folder; name the one of the masks"));
  const fs::path named = scratch_.path() / "named";
  fs::create_directories(named);
  std::ofstream(named / "first.png") << "x";
  const ProgramResult no_number = run_kinetrace({"masks", named.string(), "--publish", network_});
  EXPECT_EQ(no_number.exit_code, 65);
  EXPECT_THAT(no_number.err, AllOf(HasSubstr("first.png"), HasSubstr("--by-order")));
}

}  // namespace
}  // namespace kinetrace::test
