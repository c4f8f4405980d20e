// The program's promise: 64 MiB, all allocated at start; a budget that is too small is refused; without a budget, a
// run takes the memory of its plan.
#include <cstdint>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "budget_recording.hpp"
#include "program.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr double kMib = 1024.0 * 1024.0;
constexpr double kBudgetMib = 64.0;
constexpr int kConfigError = 78;

class ProgramBudget : public ::testing::Test {
 protected:
  ProgramResult run(const BudgetRecording& recording, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"run",
                                       "--dataset",
                                       recording.dataset,
                                       "--segmentation",
                                       recording.segmentation,
                                       "--out",
                                       (folder_.path() / "run").string(),
                                       "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_kinetrace(arguments);
  }
  ProgramResult run_with_budget(const BudgetRecording& recording, double budget_mib) {
    return run(recording, {"--frames", "2", "--set", "memory.budget_mib=" + std::to_string(budget_mib)});
  }
  /// Memory that a run needs, from the refusal of a budget of 1 MiB.
  double needed_mib(const BudgetRecording& recording) {
    const ProgramResult refused = run_with_budget(recording, 1.0);
    EXPECT_EQ(refused.exit_code, kConfigError) << refused.err;
    std::smatch missing;
    const bool says_what_is_missing = std::regex_search(
        refused.err, missing, std::regex("memory\\.budget_mib = 1\\.0 MiB is ([0-9.]+) MiB too small"));
    EXPECT_TRUE(says_what_is_missing) << refused.err;
    return says_what_is_missing ? 1.0 + std::stod(missing[1]) : 0.0;
  }
  void expect_within_budget(const BudgetRecording& recording) {
    const double needed = needed_mib(recording);
    const ProgramResult result = run(recording, {"--loop", std::to_string(passes()), "--set", "memory.budget_mib=64"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::ifstream file(folder_.path() / "run/run.json");
    const nlohmann::json run = nlohmann::json::parse(file);
    EXPECT_EQ(run["frames"], passes() * recording.frames);
    EXPECT_LE(run["rss_peak_bytes"].get<double>(), kBudgetMib * kMib);
    EXPECT_LE(run["rss_peak_bytes"].get<double>(), needed * kMib) << "more than was planned";
    EXPECT_EQ(run["allocations_after_start"], 0);
  }

  TempFolder folder_;
};

TEST_F(ProgramBudget, HoldsOnARenderedStreet) {
  expect_within_budget(rendered_clip(folder_.path()));
}

TEST_F(ProgramBudget, HoldsOnARealStreet) {
  const auto recording = street_clip();
  if (!recording) {
    GTEST_SKIP() << "no recordings: set KINETRACE_DATA";
  }
  expect_within_budget(*recording);
}

TEST_F(ProgramBudget, TooSmallIsRefusedByWhatIsMissing) {
  const BudgetRecording recording = rendered_clip(folder_.path());
  const double needed = needed_mib(recording);
  // The message rounds to a tenth.
  EXPECT_EQ(run_with_budget(recording, needed + 0.1).exit_code, 0);
  const ProgramResult refused = run_with_budget(recording, needed - 0.2);
  EXPECT_EQ(refused.exit_code, kConfigError);
  EXPECT_THAT(refused.err, ::testing::HasSubstr("memory.budget_mib"));
  EXPECT_THAT(refused.err, ::testing::ContainsRegex("0\\.[123] MiB too small"));
  std::smatch enough;
  ASSERT_TRUE(std::regex_search(refused.err, enough, std::regex("raise it to ([0-9.]+) MiB"))) << refused.err;
  EXPECT_EQ(run_with_budget(recording, std::stod(enough[1])).exit_code, 0);
  EXPECT_EQ(run_with_budget(recording, std::stod(enough[1]) - 0.1).exit_code, kConfigError);
}

TEST_F(ProgramBudget, WithoutOneARunTakesWhatItsPlanNeeds) {
  const BudgetRecording recording = rendered_clip(folder_.path());
  const double needed = needed_mib(recording);
  const ProgramResult result = run(recording, {});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::ifstream file(folder_.path() / "run/run.json");
  const nlohmann::json run = nlohmann::json::parse(file);
  EXPECT_NEAR(run["planned_bytes"].get<double>() / kMib, needed, 0.1);
  EXPECT_EQ(run["budget_bytes"], run["planned_bytes"]);
  EXPECT_LE(run["rss_peak_bytes"], run["planned_bytes"]);
}

TEST_F(ProgramBudget, DefaultsFitForTheImageSizesInUse) {
  const std::map<std::string, std::string> budgets{
      {"752x480", "64"}, {"1242x375", "64"}, {"1392x512", "64"}, {"1280x720", "71"}};
  for (const auto& [size, mib] : budgets) {
    const ProgramResult plan = run_kinetrace({"plan", "--size", size, "--set", "memory.budget_mib=" + mib});
    EXPECT_EQ(plan.exit_code, 0) << size << ": " << plan.err;
  }
}

}  // namespace
}  // namespace kinetrace::test
