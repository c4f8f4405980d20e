// Writes a recording of a chessboard for the tests of the guides: render_board FOLDER makes FOLDER/left and
// FOLDER/right.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "board_scene.hpp"
#include "rendered_board.hpp"

namespace kinetrace::calibration::test {
namespace {

void write_pgm(const std::filesystem::path& path, const kinetrace::test::BoardImage& image) {
  std::ofstream file(path, std::ios::binary);
  file << "P5\n" << image.width_px << " " << image.height_px << "\n255\n";
  file.write(reinterpret_cast<const char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size()));
}

void render(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_directories(folder / "right");
  const Target target = chessboard_target(9, 6, 0.03);
  const hal::RigCalibration rig = true_rig(Lens::kRadialTangential);
  const kinetrace::test::BoardRenderer left(target, rig.left);
  const kinetrace::test::BoardRenderer right(target, rig.right);
  std::uint32_t seed = 1000;
  for (const Se3& pose : board_poses(rig, target, {.max_tilt_rad = 0.7, .far_m = 0.7, .spread = 0.9}, 7)) {
    const std::string name = std::to_string(seed) + ".pgm";
    write_pgm(folder / "left" / name, left.render(pose, {}, seed));
    write_pgm(folder / "right" / name, right.render(rig.T_right_left * pose, {}, seed + 1000));
    ++seed;
  }
}

}  // namespace
}  // namespace kinetrace::calibration::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: render_board FOLDER\n", stderr);
    return 64;
  }
  kinetrace::calibration::test::render(argv[1]);
  return 0;
}
