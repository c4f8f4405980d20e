#include <gtest/gtest.h>

#include "kinetrace/core/memory_plan.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stage.hpp"

namespace kinetrace {
namespace {

TEST(MemoryPlan, SumsItsEntries) {
  EXPECT_EQ(MemoryPlan{}.total_bytes(), 0U);
  EXPECT_EQ((MemoryPlan{{{"features", 100, ""}, {"sfm", 23, ""}}}).total_bytes(), 123U);
}

TEST(Result, FailCarriesCodeAndMessage) {
  const Result<int> result = fail(ErrorCode::kNotFound, "calib.txt: no such file");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(result.error().message, "calib.txt: no such file");
  EXPECT_EQ(to_string(ErrorCode::kNotFound), "not_found");
}

/// Keeps the stages entered and left last.
class Watcher final : public StageObserver {
 public:
  void enter(Stage stage) noexcept override { (entered = stage, inside = true); }
  void leave(Stage stage) noexcept override { (left = stage, inside = false); }
  Stage entered = Stage::kCapture;
  Stage left = Stage::kCapture;
  bool inside = false;
};

TEST(StageScope, ReportsOneStageForItsLength) {
  Watcher watcher;
  {
    const StageScope scope(&watcher, Stage::kSfm);
    EXPECT_TRUE(watcher.inside);
    EXPECT_EQ(watcher.entered, Stage::kSfm);
  }
  EXPECT_FALSE(watcher.inside);
  EXPECT_EQ(watcher.left, Stage::kSfm);
}

TEST(Stage, EveryStageHasAName) {
  for (std::size_t i = 0; i < kStageCount; ++i) {
    EXPECT_FALSE(to_string(static_cast<Stage>(i)).empty());
  }
  EXPECT_EQ(to_string(Stage::kTrajectory), "trajectory");
}

}  // namespace
}  // namespace kinetrace
