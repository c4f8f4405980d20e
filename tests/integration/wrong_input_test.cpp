// Recordings with wrong images or masks: reported within two seconds of recording, with the remedy.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/imaging/png_writer.hpp"
#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class WrongInput : public ::testing::Test {
 protected:
  WrongInput() {
    recording_.frames = 24;
    recording_.write();
  }
  ProgramResult run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", "--dataset", recording_.dataset(), "--out", out_.string(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_kinetrace(arguments);
  }
  nlohmann::json report() const { return nlohmann::json::parse(std::ifstream(out_ / "run.json"), nullptr, false); }
  /// Count of this reason in the health report.
  int noted(const std::string& reason) const {
    const nlohmann::json run = report();
    for (const auto& entry : run["health"]["reasons"]) {
      if (entry["reason"] == reason) {
        return entry["count"];
      }
    }
    return 0;
  }
  void replace(int view, int frame, int by_view, int by_frame) const {
    fs::copy_file(recording_.image(by_view, by_frame), recording_.image(view, frame),
                  fs::copy_options::overwrite_existing);
  }
  /// Writes a mask for each frame, by its index.
  fs::path write_masks(const std::function<void(const fs::path& file, int frame)>& write) const {
    const fs::path folder = scratch_.path() / "masks";
    fs::create_directories(folder);
    for (int frame = 0; frame < recording_.frames; ++frame) {
      write(folder / recording_.image(0, frame).filename(), frame);
    }
    return folder;
  }
  static void write_gray(const fs::path& file, int width, int height) {
    const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    ASSERT_TRUE(imaging::write_png_gray8(file.c_str(), GrayView{pixels.data(), width, height, width}));
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  fs::path out_ = scratch_.path() / "out";
};

TEST_F(WrongInput, AGoodRecordingHasNone) {
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(report()["health"]["worst"], "ok");
}

TEST_F(WrongInput, ExchangedCamerasEndTheRun) {
  fs::rename(recording_.sequence() / "image_0", recording_.sequence() / "x");
  fs::rename(recording_.sequence() / "image_1", recording_.sequence() / "image_0");
  fs::rename(recording_.sequence() / "x", recording_.sequence() / "image_1");
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, AllOf(HasSubstr(recording_.dataset()), HasSubstr("exchanged")));
  EXPECT_LT(report()["frames"], 20) << "within two seconds";
  EXPECT_EQ(report()["exit_status"], kBadData);
  EXPECT_GE(noted("views_exchanged"), 1);
  const ProgramResult anyway = run({"--set", "input.unusable=warn"});
  EXPECT_EQ(anyway.exit_code, 0);
  EXPECT_THAT(anyway.err, HasSubstr("exchanged"));
  EXPECT_EQ(report()["frames"], recording_.frames);
}

TEST_F(WrongInput, OneImageInBothCamerasEndsTheRun) {
  for (int frame = 0; frame < recording_.frames; ++frame) {
    replace(1, frame, 0, frame);
  }
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, AllOf(HasSubstr(recording_.dataset()), HasSubstr("equal bit by bit")));
  EXPECT_GE(noted("views_identical"), 1);
}

TEST_F(WrongInput, AFrozenCameraIsSaidOnceAndNoted) {
  for (int frame = 4; frame < recording_.frames; ++frame) {
    replace(0, frame, 0, 3);
    replace(1, frame, 1, 3);
  }
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("both images are the same bit by bit"));
  EXPECT_EQ(result.err.find("bit by bit"), result.err.rfind("bit by bit")) << "once: " << result.err;
  EXPECT_GE(noted("images_frozen"), 10);
  EXPECT_EQ(report()["health"]["worst"], "degraded");
}

TEST_F(WrongInput, MasksOfAnotherSizeEndTheRunWithTheFirstOnesName) {
  const fs::path masks = write_masks([](const fs::path& file, int) { write_gray(file, 100, 100); });
  const ProgramResult result = run({"--segmentation", "masks:" + masks.string()});
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, AllOf(HasSubstr((masks / "000000.png").string()), HasSubstr("100x100")));
  EXPECT_GE(noted("masks_unreadable"), 20);
}

TEST_F(WrongInput, MasksThatAreCutOffEndTheRun) {
  const fs::path masks = write_masks([](const fs::path& file, int) {
    write_gray(file, SmallRecording::kWidth, SmallRecording::kHeight);
    truncate_file(file, 80);
  });
  EXPECT_EQ(run({"--segmentation", "masks:" + masks.string()}).exit_code, kBadData);
}

TEST_F(WrongInput, MasksNamedForOtherImagesEndTheRun) {
  const fs::path masks = write_masks([](const fs::path& file, int) {
    write_gray(file.parent_path() / ("mask_" + file.filename().string()), SmallRecording::kWidth,
               SmallRecording::kHeight);
  });
  const ProgramResult result = run({"--segmentation", "masks:" + masks.string()});
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, HasSubstr("named like the left images"));
}

TEST_F(WrongInput, PicturesInPlaceOfMasksEndTheRun) {
  const fs::path folder = fs::path(recording_.image(0, 0)).parent_path();
  const ProgramResult result = run({"--segmentation", "masks:" + folder.string()});
  EXPECT_EQ(result.exit_code, 65) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("is a picture, not masks"), HasSubstr(folder.string())));
}

TEST_F(WrongInput, MasksOfNothingButWhatIsIgnoredEndTheRun) {
  const fs::path masks = write_masks([](const fs::path& file, int) {
    std::vector<std::uint8_t> pixels(std::size_t{SmallRecording::kWidth} * SmallRecording::kHeight, 0);
    std::fill_n(pixels.begin() + 10 * SmallRecording::kWidth, 40 * SmallRecording::kWidth, std::uint8_t{255});
    const GrayView mask{pixels.data(), SmallRecording::kWidth, SmallRecording::kHeight, SmallRecording::kWidth};
    ASSERT_TRUE(imaging::write_png_gray8(file.c_str(), mask));
  });
  const ProgramResult result = run({"--segmentation", "masks:" + masks.string()});
  EXPECT_EQ(result.exit_code, kBadData);
  EXPECT_THAT(result.err, HasSubstr("nothing but 255"));
}

TEST_F(WrongInput, IsSaidWhileItIsRecorded) {
  for (int frame = 0; frame < recording_.frames; ++frame) {
    replace(1, frame, 0, frame);
  }
  const fs::path camera = scratch_.path() / "camera.yaml";
  std::ofstream(camera) << "source: files\nfiles:\n  layout: kitti-odometry\n  path: " << recording_.sequence().string()
                        << "\n";
  const ProgramResult result =
      run_kinetrace({"record", "--camera", camera.string(), "--out", out_.string(), "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("equal bit by bit"));
}

TEST_F(WrongInput, ADamagedMaskIsReportedAndTheRunContinues) {
  const fs::path masks = write_masks([](const fs::path& file, int frame) {
    write_gray(file, SmallRecording::kWidth, SmallRecording::kHeight);
    if (frame == 5) {
      truncate_file(file, 80);
    }
  });
  const ProgramResult result = run({"--segmentation", "masks:" + masks.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr((masks / "000005.png").string()));
  EXPECT_EQ(report()["counters"]["mask_files_unreadable"], 1);
  EXPECT_EQ(report()["health"]["worst"], "degraded");
}

TEST_F(WrongInput, ManyDamagedMasksTakeNoMoreMemoryThanOne) {
  const auto allocations = [this](int damaged) {
    const fs::path masks = write_masks([damaged](const fs::path& file, int frame) {
      write_gray(file, SmallRecording::kWidth, SmallRecording::kHeight);
      if (frame > 0 && frame <= damaged) {
        truncate_file(file, 80);
      }
    });
    const ProgramResult result = run({"--segmentation", "masks:" + masks.string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(report()["counters"]["mask_files_unreadable"], damaged);
    return report()["allocations_after_start"];
  };
  // Both runs allocate for one warning.
  EXPECT_EQ(allocations(12), allocations(1));
}

}  // namespace
}  // namespace kinetrace::test
