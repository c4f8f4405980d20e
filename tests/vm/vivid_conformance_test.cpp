// Live cameras made of V4L2 devices pass the conformance suite.
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

INSTANTIATE_TEST_SUITE_P(Vivid, CameraConformance,
                         ::testing::Values(CameraKind{"V4l2Pair", &make_pair},
                                           CameraKind{"V4l2ConvertedPair", &make_converted_pair},
                                           CameraKind{"V4l2SideBySide", &make_side_by_side}),
                         name_of_kind);

}  // namespace
}  // namespace kinetrace::hal::test
