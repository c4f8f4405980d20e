// Recordings pass the conformance suite of cameras.
#include <memory>

#include "camera_conformance.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

class FileBench final : public CameraBench {
 public:
  explicit FileBench(int frames, FileCameraConfig config)
      : recording_(frames),
        dataset_(recording_.open().value()),
        arena_(FileStereoCamera::required_bytes(dataset_, config)),
        camera_(FileStereoCamera::create(dataset_, config, arena_).value()) {}
  StereoCamera& camera() override { return camera_; }

 private:
  Recording recording_;
  Dataset dataset_;
  Arena arena_;
  FileStereoCamera camera_;
};

std::unique_ptr<CameraBench> make_file() {
  return std::make_unique<FileBench>(3, FileCameraConfig{});
}
std::unique_ptr<CameraBench> make_looping_file() {
  return std::make_unique<FileBench>(2, FileCameraConfig{.passes = 2});
}

INSTANTIATE_TEST_SUITE_P(Recordings, CameraConformance,
                         ::testing::Values(CameraKind{"File", &make_file},
                                           CameraKind{"LoopingFile", &make_looping_file}),
                         name_of_kind);

}  // namespace
}  // namespace kinetrace::hal::test
