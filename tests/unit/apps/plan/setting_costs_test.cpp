// Costs of settings, on a small test configuration; and the boards known to the program.
#include "plan/setting_costs.hpp"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "config/board_config.hpp"
#include "config/board_profiles.hpp"

namespace kinetrace::app {
namespace {

struct Shed {
  int bikes = 4;
  int hooks = 3;
  bool lamp = true;
  double height_m = 2.0;
};

template <typename Visitor>
void visit_fields(Shed& shed, Visitor&& visit) {
  visit("bikes", shed.bikes, "1000 bytes each.");
  visit("hooks", shed.hooks, "At most 3; 200 bytes each.");
  visit("lamp", shed.lamp, "50 bytes.");
  visit("height_m", shed.height_m, "Takes nothing.");
}

Result<double> bytes_of(const Shed& shed) {
  if (shed.hooks > 3) {
    return fail(ErrorCode::kInvalidConfig, "too many hooks");
  }
  return 1000.0 * shed.bikes + 200.0 * shed.hooks + (shed.lamp ? 50.0 : 0.0);
}

TEST(SettingCosts, AreWhatOneMoreTakesTheLargestShareFirst) {
  Shed shed;
  const auto costs = setting_costs(fields_of(shed), [&] { return bytes_of(shed); });
  ASSERT_EQ(costs.size(), 3U);
  EXPECT_EQ(costs[0].key, "bikes");
  EXPECT_EQ(costs[0].value, "4");
  EXPECT_EQ(costs[0].bytes, 1000.0);
  EXPECT_EQ(costs[0].share_bytes, 4000.0);
  EXPECT_EQ(costs[1].key, "hooks") << "one more is not valid, one less is";
  EXPECT_EQ(costs[1].bytes, 200.0);
  EXPECT_EQ(costs[2].key, "lamp");
  EXPECT_EQ(costs[2].bytes, 50.0);
}

TEST(SettingCosts, LeaveTheConfigurationAsItWas) {
  Shed shed{.lamp = false};
  const auto costs = setting_costs(fields_of(shed), [&] { return bytes_of(shed); });
  EXPECT_EQ(shed.bikes, 4);
  EXPECT_EQ(shed.hooks, 3);
  EXPECT_FALSE(shed.lamp);
  ASSERT_EQ(costs.size(), 3U);
  EXPECT_EQ(costs[2].share_bytes, 0.0) << "it is off";
}

TEST(SettingCosts, AreNoneWhereThePlanFails) {
  Shed shed{.hooks = 5};
  EXPECT_TRUE(setting_costs(fields_of(shed), [&] { return bytes_of(shed); }).empty());
}

TEST(BoardProfiles, AreTheFilesOfTheirFolder) {
  ASSERT_GE(board_profiles().size(), 4U);
  for (const BoardProfile& profile : board_profiles()) {
    std::ostringstream text;
    text << std::ifstream(std::string(KINETRACE_SOURCE_DIR) + "/config/boards/" + std::string(profile.name) + ".yaml")
                .rdbuf();
    EXPECT_EQ(profile.yaml, text.str()) << profile.name;
  }
}

TEST(BoardConfig, RefusesWhatNoBoardHas) {
  EXPECT_TRUE(BoardConfig{}.validate());
  for (const BoardConfig& wrong : {BoardConfig{.cores = -1}, BoardConfig{.memory_mib = -1},
                                   BoardConfig{.image_width_px = 63}, BoardConfig{.image_height_px = 9000}}) {
    EXPECT_FALSE(wrong.validate());
  }
}

}  // namespace
}  // namespace kinetrace::app
