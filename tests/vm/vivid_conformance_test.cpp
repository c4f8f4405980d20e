// Live cameras made of V4L2 devices do what every camera must.
#include "live_bench.hpp"
#include "vivid.hpp"

namespace kinetrace::hal::test {
namespace {

std::unique_ptr<CameraBench> make_pair() {
  return std::make_unique<LiveBench>(live_config(vivid_config(kVividLeft), vivid_config(kVividRight)));
}
std::unique_ptr<CameraBench> make_converted_pair() {
  return std::make_unique<LiveBench>(
      live_config(vivid_config(kVividLeft, PixelFormat::kYuyv), vivid_config(kVividRight, PixelFormat::kGrey16)));
}
std::unique_ptr<CameraBench> make_side_by_side() {
  return std::make_unique<LiveBench>(live_config(vivid_config(kVividLeft), std::nullopt));
}

INSTANTIATE_TEST_SUITE_P(V4l2Pair, CameraConformance, ::testing::Values(&make_pair));
INSTANTIATE_TEST_SUITE_P(V4l2ConvertedPair, CameraConformance, ::testing::Values(&make_converted_pair));
INSTANTIATE_TEST_SUITE_P(V4l2SideBySide, CameraConformance, ::testing::Values(&make_side_by_side));

}  // namespace
}  // namespace kinetrace::hal::test
