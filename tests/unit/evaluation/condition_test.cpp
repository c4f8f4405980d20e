#include "kinetrace/evaluation/condition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr const char* kJson = R"({"camera": {"t_rel": 0.5, "r_rel": null, "name": "x"}, "list": [1, {"n": 2}],
                             "objects": null})";

bool holds(const char* text) {
  return check(parse_condition(text).value(), kJson).value().holds;
}

TEST(Condition, ComparesANumberOfTheEvaluation) {
  EXPECT_FALSE(holds("camera.t_rel>0.5"));
  EXPECT_TRUE(holds("camera.t_rel>=0.5"));
  EXPECT_FALSE(holds("camera.t_rel<0.5"));
  EXPECT_TRUE(holds("camera.t_rel<=0.5"));
  EXPECT_TRUE(holds("camera.t_rel==0.5"));
  EXPECT_FALSE(holds("camera.t_rel==0.6"));
  EXPECT_TRUE(holds("camera.t_rel > -1e-3"));
}

TEST(Condition, FindsPlacesInLists) {
  EXPECT_TRUE(holds("list.0==1"));
  EXPECT_TRUE(holds("list.1.n==2"));
}

TEST(Condition, TellsWhatWasFound) {
  EXPECT_DOUBLE_EQ(check(parse_condition("camera.t_rel>1").value(), kJson).value().value, 0.5);
}

TEST(Condition, RefusesWhatIsNoCondition) {
  for (const char* text : {"", "camera.t_rel", ">1", "camera.t_rel>", "camera.t_rel>x", "camera.t_rel>1x",
                           "camera.t_rel=1", "camera.t_rel=>1", "a>1>2", "camera.t_rel>nan"}) {
    const Result<Condition> condition = parse_condition(text);
    ASSERT_FALSE(condition) << text;
    EXPECT_EQ(condition.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(condition.error().message, HasSubstr("camera.t_rel>1.0"));
  }
}

TEST(Condition, RefusesAPathThatDoesNotExist) {
  for (const char* text :
       {"camera.x>1", "x>1", "camera>1", "camera.name>1", "list.2>1", "list.-1>1", "list>1", "camera.t_rel.x>1"}) {
    const Result<ConditionOutcome> outcome = check(parse_condition(text).value(), kJson);
    ASSERT_FALSE(outcome) << text;
    EXPECT_EQ(outcome.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(Condition, SuggestsTheNameThatWasMeant) {
  const Result<ConditionOutcome> outcome = check(parse_condition("camera.trel>1").value(), kJson);
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().message, HasSubstr("no 'trel' there; did you mean t_rel?"));
}

TEST(Condition, RefusesWhatCouldNotBeMeasured) {
  for (const char* path : {"camera.r_rel", "objects.coverage"}) {
    const Result<ConditionOutcome> outcome = check(parse_condition(std::string(path) + ">1").value(), kJson);
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(outcome.error().message, HasSubstr(std::string(path) + " could not be measured"));
  }
}

}  // namespace
}  // namespace kinetrace::evaluation
