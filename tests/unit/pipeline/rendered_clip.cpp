#include "rendered_clip.hpp"

#include <fstream>
#include <stdexcept>

#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::test {
namespace {

void write_image(const std::filesystem::path& path, GrayView image) {
  if (!imaging::write_png_gray8(path.c_str(), image)) {
    throw std::runtime_error("cannot write " + path.string());
  }
}

void write_calibration(const std::filesystem::path& sequence, const StereoGeometry& rig) {
  std::ofstream file(sequence / "calib.txt");
  for (int view = 0; view < 2; ++view) {
    file << "P" << view << ": " << rig.fx_px << " 0 " << rig.cx_px << " " << -view * rig.fx_px * rig.baseline_m << " 0 "
         << rig.fy_px << " " << rig.cy_px << " 0 0 0 1 0\n";
  }
}

}  // namespace

RenderedClip write_rendered_clip(const std::filesystem::path& folder, int frames) {
  return write_rendered_clip(folder, StreetDrive({Mover{}}), frames);
}

RenderedClip write_rendered_clip(const std::filesystem::path& folder, const StreetDrive& street, int frames) {
  const std::filesystem::path sequence = folder / "sequences/00";
  for (const char* view : {"image_0", "image_1"}) {
    std::filesystem::create_directories(sequence / view);
  }
  write_calibration(sequence, street.geometry());
  std::ofstream times(sequence / "times.txt");
  for (int frame = 0; frame < frames; ++frame) {
    const RenderedPair pair = street.render(frame);
    times << StreetDrive::kFrame_s * frame << "\n";
    write_image(sequence / "image_0" / (stem_of(frame) + ".png"), pair.view(pair.left));
    write_image(sequence / "image_1" / (stem_of(frame) + ".png"), pair.view(pair.right));
    write_masks(pair, frame, folder);
  }
  return {"kitti-odometry:" + sequence.string(),
          "masks:" + (folder / "left").string() + "," + (folder / "right").string(), frames};
}

}  // namespace kinetrace::test
