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

void render(const std::filesystem::path& folder, const Target& target, double scale, const Motion& motion) {
  std::filesystem::create_directories(folder / "left");
  std::filesystem::create_directories(folder / "right");
  const hal::RigCalibration rig = true_rig(Lens::kRadialTangential, scale);
  const kinetrace::test::BoardRenderer left(target, rig.left);
  const kinetrace::test::BoardRenderer right(target, rig.right);
  std::uint32_t seed = 1000;
  for (const Se3& pose : board_poses(rig, target, motion, 7)) {
    const std::string name = std::to_string(seed) + ".pgm";
    write_pgm(folder / "left" / name, left.render(pose, {}, seed));
    write_pgm(folder / "right" / name, right.render(rig.T_right_left * pose, {}, seed + 1000));
    ++seed;
  }
}

}  // namespace
}  // namespace kinetrace::calibration::test

int main(int argc, char** argv) {
  using namespace kinetrace::calibration;
  if (argc == 2) {
    test::render(argv[1], chessboard_target(9, 6, 0.03), 1.0, {.max_tilt_rad = 0.7, .far_m = 0.7, .spread = 0.9});
    return 0;
  }
  if (argc == 3 && std::string(argv[2]) == "small") {
    test::render(argv[1], charuco_target(8, 6, 0.04, 0.031, "DICT_4X4_100"), 0.5,
                 {.views = 40, .max_tilt_rad = 0.7, .near_m = 0.28, .far_m = 0.42, .spread = 0.8});
    return 0;
  }
  std::fputs("usage: render_board FOLDER [small]\n", stderr);
  return 64;
}
