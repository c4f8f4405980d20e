#include "budget_recording.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "kinetrace/imaging/png_writer.hpp"
#include "street_drive.hpp"

namespace kinetrace::test {
namespace {

constexpr int kRenderedFrames = 20;

void write_image(const std::filesystem::path& path, GrayView image) {
  if (!imaging::write_png_gray8(path.c_str(), image)) {
    throw std::runtime_error("cannot write " + path.string());
  }
}

void write_calibration(const std::filesystem::path& sequence, const StereoGeometry& rig) {
  std::ofstream file(sequence / "calib.txt");
  for (int eye = 0; eye < 2; ++eye) {
    file << "P" << eye << ": " << rig.fx_px << " 0 " << rig.cx_px << " " << -eye * rig.fx_px * rig.baseline_m << " 0 "
         << rig.fy_px << " " << rig.cy_px << " 0 0 0 1 0\n";
  }
}

}  // namespace

std::optional<BudgetRecording> street_clip() {
  const char* named = std::getenv("KINETRACE_DATA");
  const std::filesystem::path data = named != nullptr ? named : KINETRACE_DEFAULT_DATA;
  const std::filesystem::path drive = data / "kitti_raw/2011_09_26/2011_09_26_drive_0039_extract";
  const std::filesystem::path masks = data / "masks/kitti_raw_0039";
  if (!std::filesystem::is_directory(drive / "image_00/data") || !std::filesystem::is_directory(masks)) {
    return std::nullopt;
  }
  const auto images = std::filesystem::directory_iterator(drive / "image_00/data");
  return BudgetRecording{"kitti-raw:" + drive.string(),
                         "masks:" + (masks / "detections_left").string() + "," + (masks / "detections_right").string(),
                         static_cast<int>(std::distance(begin(images), end(images)))};
}

BudgetRecording rendered_clip(const std::filesystem::path& folder) {
  const StreetDrive street({Mover{}});
  const std::filesystem::path sequence = folder / "sequences/00";
  for (const char* eye : {"image_0", "image_1"}) {
    std::filesystem::create_directories(sequence / eye);
  }
  write_calibration(sequence, street.geometry());
  std::ofstream times(sequence / "times.txt");
  for (int frame = 0; frame < kRenderedFrames; ++frame) {
    const RenderedPair pair = street.render(frame);
    times << StreetDrive::kFrame_s * frame << "\n";
    write_image(sequence / "image_0" / (stem_of(frame) + ".png"), pair.view(pair.left));
    write_image(sequence / "image_1" / (stem_of(frame) + ".png"), pair.view(pair.right));
    write_masks(pair, frame, folder);
  }
  return {"kitti-odometry:" + sequence.string(),
          "masks:" + (folder / "left").string() + "," + (folder / "right").string(), kRenderedFrames};
}

int passes() {
  constexpr int kQuick = 6;
  constexpr int kLong = 50;
  return std::getenv("KINETRACE_LONG_TESTS") != nullptr ? kLong : kQuick;
}

}  // namespace kinetrace::test
