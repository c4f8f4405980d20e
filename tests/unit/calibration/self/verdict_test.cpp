#include "verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::self_calibration {
namespace {

using ::testing::HasSubstr;

Findings good() {
  return {8, 0.8, 0.05, {8000, 60.0, 50.0, 5.0, 0.3}, 0.001, 0.004};
}

std::string reason(const Findings& findings) {
  const Status status = verdict(findings);
  return status ? "accepted" : status.error().message;
}

TEST(Verdict, AcceptsWhatDeterminesTheRig) {
  EXPECT_EQ(reason(good()), "accepted");
}

TEST(Verdict, SaysWhyItRefuses) {
  Findings few = good();
  few.scene.points = 700;
  EXPECT_THAT(reason(few), HasSubstr("too few points"));
  Findings short_recording = good();
  short_recording.windows = 2;
  EXPECT_THAT(reason(short_recording), HasSubstr("too few points"));
  Findings misfit = good();
  misfit.sigma_px = 0.6;
  EXPECT_THAT(reason(misfit), HasSubstr("no rig explains"));
  Findings focal = good();
  focal.focal_sigma = 0.006;
  EXPECT_THAT(reason(focal), HasSubstr("focal length stays open (0.6 %)"));
  Findings depth = good();
  depth.depth_sigma = 0.05;
  EXPECT_THAT(reason(depth), HasSubstr("distances stay open (5.0 %"));
}

TEST(Verdict, RefusesWhatIsNoNumber) {
  Findings findings = good();
  findings.focal_sigma = std::nan("");
  EXPECT_THAT(reason(findings), HasSubstr("focal length stays open"));
}

}  // namespace
}  // namespace kinetrace::self_calibration
