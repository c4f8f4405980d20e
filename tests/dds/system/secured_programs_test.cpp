// The reading programs, and the sender of masks, with keys of `kinetrace keys`.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/png_writer.hpp"
#include "network.hpp"
#include "parts.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kConfig = 78;
constexpr int kNothingReceived = 74;

class DdsSecuredPrograms : public OwnNetworkTest {
 protected:
  void SetUp() override {
    OwnNetworkTest::SetUp();
    if (IsSkipped()) {
      return;
    }
    make_keys(keys_, {"--device", "kinetrace", "--viewer", "viewer", "--segmenter", "segmenter"});
    make_keys(scratch_.path() / "foreign", {"--viewer", "viewer", "--segmenter", "segmenter"});
  }
  [[nodiscard]] std::string settings(const char* name) const { return (enclave(keys_, name) / "dds.yaml").string(); }
  [[nodiscard]] std::string foreign_settings(const char* name) const {
    return (enclave(scratch_.path() / "foreign", name) / "dds.yaml").string();
  }
  [[nodiscard]] static Command monitor(const std::string& settings, const Command& more) {
    Command command = kinetrace_command({"monitor", "--json", "--publish", settings});
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  TempFolder scratch_;
  fs::path keys_ = scratch_.path() / "keys";
};

TEST_F(DdsSecuredPrograms, MonitorHearsAndRecordsWithTheKeysOfAViewer) {
  const Process scene(scene_command(secured_by(enclave(keys_, "kinetrace"))));
  const fs::path recorded = scratch_.path() / "run.mcap";
  const Ending received =
      run_to_end(monitor(settings("viewer"), {"--messages", "60", "--seconds", "60", "--record", recorded.string()}));
  EXPECT_EQ(received.exit_code, 0) << received.err;
  EXPECT_THAT(received.out, AllOf(HasSubstr("\"camera\""), HasSubstr("\"objects\"")));
  EXPECT_GT(fs::file_size(recorded), 20'000U);
}

TEST_F(DdsSecuredPrograms, MonitorHearsNothingWithoutThem) {
  const Process scene(scene_command(secured_by(enclave(keys_, "kinetrace"))));
  const Process entitled(monitor(settings("viewer"), {"--seconds", "60"}));
  const std::string unsecured = scratch_.file("unsecured.yaml");
  std::ofstream(unsecured) << "dds:\n  interface: lo\n";
  for (const std::string& other : {unsecured, foreign_settings("viewer")}) {
    const Ending ending = run_to_end(monitor(other, {"--seconds", "5"}));
    EXPECT_EQ(ending.exit_code, kNothingReceived) << other << ending.err;
    EXPECT_THAT(ending.out, Not(HasSubstr("\"objects\"")));
  }
  EXPECT_THAT(entitled.out(), HasSubstr("\"objects\"")) << "there was something to hear: " << entitled.err();
  const Ending device = run_to_end(monitor(settings("kinetrace"), {"--seconds", "5"}));
  EXPECT_EQ(device.exit_code, kConfig);
  EXPECT_THAT(device.err, AllOf(HasSubstr("permissions.p7s"), HasSubstr("allow its topics")));
}

TEST_F(DdsSecuredPrograms, DoctorSaysWhoElseIsThere) {
  const Command doctor = kinetrace_command({"doctor", "--publish", settings("kinetrace")});
  EXPECT_THAT(run_to_end(doctor).out, HasSubstr("dds          domain 0 on lo, secured; 0 other participants"));
  const Process viewer(monitor(settings("viewer"), {"--seconds", "60"}));
  const Process stranger(monitor(foreign_settings("viewer"), {"--seconds", "60"}));
  const Process scene(scene_command(secured_by(enclave(keys_, "kinetrace"))));
  ASSERT_TRUE(viewer.until([](const nlohmann::json&) { return true; })) << viewer.err();
  const Ending ending = run_to_end(doctor);
  EXPECT_EQ(ending.exit_code, 0) << ending.out << ending.err;
  EXPECT_THAT(ending.out, HasSubstr("domain 0 on lo, secured; 3 other participants seen"))
      << "strangers are received too";
}

/// A run whose masks come over the network.
class DdsSecuredMasks : public DdsSecuredPrograms {
 protected:
  void SetUp() override {
    DdsSecuredPrograms::SetUp();
    recording_.write();
    fs::create_directories(masks_);
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(SmallRecording::kWidth) * SmallRecording::kHeight);
    for (int y = 40; y < 120; ++y) {
      std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(y) * SmallRecording::kWidth + 50, 100, 1001);
    }
    for (int frame = 0; frame < recording_.frames; ++frame) {
      const fs::path file = masks_ / (std::to_string(frame) + ".png");
      ASSERT_TRUE(imaging::write_png_gray16(
          file.c_str(), {pixels.data(), SmallRecording::kWidth, SmallRecording::kHeight, SmallRecording::kWidth}));
    }
  }
  [[nodiscard]] Command sender(const std::string& settings) const {
    return kinetrace_command({"masks", masks_.string(), "--publish", settings, "--seconds", "60"});
  }
  /// The run's messages about masks, with its counters.
  [[nodiscard]] std::string run_with_masks() const {
    const fs::path out = scratch_.path() / "out";
    const Ending ending = run_to_end(
        kinetrace_command({"run", "--dataset", recording_.dataset(), "--out", out.string(), "--quiet", "--segmentation",
                           "dds", "--publish", settings("kinetrace"), "--set", "segmentation.dds.timeout_ms=3000"}));
    EXPECT_EQ(ending.exit_code, 0) << ending.err;
    std::ostringstream content;
    content << std::ifstream(out / "run.json").rdbuf();
    return ending.err + content.str();
  }

  SmallRecording recording_{.root = scratch_.path() / "recording"};
  fs::path masks_ = scratch_.path() / "masks";
};

TEST_F(DdsSecuredMasks, ComeFromASegmenter) {
  const Process segmenter(sender(settings("segmenter")));
  EXPECT_THAT(run_with_masks(), AllOf(HasSubstr("\"mask_frames_taken\": 6"), Not(HasSubstr("no process sends masks"))));
}

TEST_F(DdsSecuredMasks, AreNotTakenFromStrangers) {
  const Process foreign(sender(foreign_settings("segmenter")));
  EXPECT_THAT(run_with_masks(), AllOf(HasSubstr("no process sends masks"), HasSubstr("\"mask_frames_taken\": 0")));
}

TEST_F(DdsSecuredMasks, AViewerMaySendNone) {
  const Ending viewer = run_to_end(sender(settings("viewer")));
  EXPECT_EQ(viewer.exit_code, kConfig);
  EXPECT_THAT(viewer.err, AllOf(HasSubstr("permissions.p7s"), HasSubstr("allow its topics")));
}

}  // namespace
}  // namespace kinetrace::test
