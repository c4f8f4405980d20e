// Live cameras made of USB cameras, through V4L2 and through libcamera, pass the conformance suite.
#include "backends.hpp"
#include "live_bench.hpp"
#include "uvc/uvc_pair.hpp"

namespace kinetrace::hal::test {
namespace {

std::unique_ptr<CameraBench> make_bench(CaptureBackend backend, PixelFormat format) {
  UvcPair& pair = UvcPair::instance();
  UvcPair::wait_until_listed(backend, 2);
  return std::make_unique<LiveBench>(live_config(pair.config(backend, 0, format), pair.config(backend, 1, format)));
}
std::unique_ptr<CameraBench> make_v4l2() {
  return make_bench(CaptureBackend::kV4l2, PixelFormat::kMjpeg);
}
std::unique_ptr<CameraBench> make_libcamera() {
  use_all_backends();
  return make_bench(CaptureBackend::kLibcamera, PixelFormat::kYuyv);
}

INSTANTIATE_TEST_SUITE_P(Uvc, CameraConformance,
                         ::testing::Values(CameraKind{"V4l2", &make_v4l2}, CameraKind{"Libcamera", &make_libcamera}),
                         name_of_kind);

}  // namespace
}  // namespace kinetrace::hal::test
