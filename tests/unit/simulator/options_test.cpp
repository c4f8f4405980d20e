#include "options.hpp"

#include <array>

#include <gtest/gtest.h>

namespace kinetrace::simulator {
namespace {

template <std::size_t N>
app::Outcome<std::optional<Options>> parse(const std::array<const char*, N>& arguments) {
  return parse_options(static_cast<int>(N), arguments.data());
}

TEST(Options, TakesEverythingFromTheCommandLine) {
  const auto options = parse(std::array{"kinetrace-simulate",
                                        "drone",
                                        "--out",
                                        "/tmp/x",
                                        "--frames",
                                        "7",
                                        "--seed",
                                        "3",
                                        "--width",
                                        "320",
                                        "--noise",
                                        "0.5",
                                        "--degrade",
                                        "off",
                                        "--samples",
                                        "9",
                                        "--distortion",
                                        "--rate",
                                        "5",
                                        "--missing",
                                        "40"});
  ASSERT_TRUE(options && *options);
  const Options& o = **options;
  EXPECT_EQ(o.scene, "drone");
  EXPECT_EQ(o.recording.folder, "/tmp/x");
  EXPECT_EQ(o.frames, 7);
  EXPECT_EQ(o.simulator.seed, 3U);
  EXPECT_EQ(o.width_px, 320);
  EXPECT_FALSE(o.height_px);
  EXPECT_DOUBLE_EQ(o.simulator.sensor.noise_levels, 0.5);
  EXPECT_FALSE(o.recording.degrade);
  EXPECT_EQ(o.simulator.samples_per_side, 3);
  EXPECT_TRUE(o.simulator.distortion);
  EXPECT_EQ(o.rate_hz, 5.0);
  EXPECT_DOUBLE_EQ(o.recording.degradation.miss_probability, 0.4);
}

TEST(Options, RefusesWhatItCannotDo) {
  const auto expect_usage = [](const auto& outcome, const char* hint) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, app::ExitCode::kUsage);
    EXPECT_NE(outcome.error().message.find(hint), std::string::npos) << outcome.error().message;
  };
  expect_usage(parse(std::array{"kinetrace-simulate", "street"}), "--out");
  expect_usage(parse(std::array{"kinetrace-simulate", "--out", "x"}), "SCENE");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", ""}), "--out: must not be empty");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "--quiet"}), "--out: needs a value");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--samples", "5"}), "--samples");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--frames", "0"}), "--frames");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--rate", "nan"}), "--rate: must be in");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--knock", "nan"}),
               "--knock: must be in");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--degrade", "much"}), "--degrade");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--missing", "101"}), "--missing");
  expect_usage(parse(std::array{"kinetrace-simulate", "street", "--out", "x", "--fraems", "3"}),
               "--fraems: no such option; did you mean --frames?");
}

}  // namespace
}  // namespace kinetrace::simulator
