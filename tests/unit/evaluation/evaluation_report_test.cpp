#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/evaluation/evaluation.hpp"
#include "object_scene.hpp"

namespace kinetrace::evaluation {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Evaluation perfect_evaluation() {
  Evaluation evaluation;
  evaluation.run = "run";
  evaluation.truth = "truth";
  evaluation.truth_format = "simulator";
  std::vector<PosePair> pairs;
  for (int i = 0; i < 30; ++i) {
    const Se3 pose{Eigen::Matrix3d::Identity(), {0.0, 0.0, static_cast<double>(i)}};
    pairs.push_back({i, pose, pose});
  }
  evaluation.camera = evaluate_camera(pairs);
  evaluation.objects = evaluate_objects(perfect_scene(), {});
  evaluation.masks = MaskMetrics().report();
  for (MaskScores* scores : {&evaluation.masks->combined, &evaluation.masks->any_class}) {
    scores->mots.tp = 1;
  }
  return evaluation;
}

nlohmann::json json_of(const Evaluation& evaluation) {
  return nlohmann::json::parse(evaluation_json(evaluation));
}

TEST(EvaluationJson, HasTheNamesThatConditionsUse) {
  const nlohmann::json json = json_of(perfect_evaluation());
  for (const char* path : {"/camera/frames",
                           "/camera/path",
                           "/camera/t_rel",
                           "/camera/r_rel",
                           "/camera/segments/0/length",
                           "/camera/ate/first/rmse",
                           "/camera/ate/se3/rmse",
                           "/camera/ate/sim3/mean",
                           "/camera/ate/scale",
                           "/camera/rpe/translation/mean",
                           "/camera/rpe/rotation/max",
                           "/objects/count",
                           "/objects/coverage",
                           "/objects/id_switches",
                           "/objects/fragmentations",
                           "/objects/motion/translation/mean",
                           "/objects/motion/rotation/rmse",
                           "/objects/motion/pairs",
                           "/objects/motion/missing",
                           "/objects/motion/tracked/translation/mean",
                           "/objects/distance/mean",
                           "/objects/offset/max",
                           "/objects/center/mean",
                           "/objects/speed/mean",
                           "/objects/heading/mean",
                           "/objects/moving_found",
                           "/objects/false_moving",
                           "/objects/each/0/coverage",
                           "/objects/worst_motions/0/translation",
                           "/masks/hota",
                           "/masks/deta",
                           "/masks/assa",
                           "/masks/smotsa",
                           "/masks/motsa",
                           "/masks/any_class/hota"}) {
    const nlohmann::json::json_pointer pointer(path);
    ASSERT_TRUE(json.contains(pointer)) << path;
    EXPECT_TRUE(json.at(pointer).is_number()) << path;
  }
  EXPECT_EQ(json["objects"]["coverage"], 100.0);
  EXPECT_EQ(json["objects"]["false_moving"], 0);
  EXPECT_EQ(json["objects"]["motion"]["pairs"], kSceneFrames - 1);
  EXPECT_EQ(json["objects"]["each"][0]["tracks"], nlohmann::json({11}));
  EXPECT_TRUE(json["objects"]["motion"]["propagated"]["translation"]["mean"].is_null());
}

TEST(EvaluationJson, HasNullForWhatCouldNotBeMeasured) {
  const nlohmann::json json = json_of({});
  EXPECT_TRUE(json["camera"]["t_rel"].is_null());
  EXPECT_TRUE(json["camera"]["ate"]["se3"]["rmse"].is_null());
  EXPECT_TRUE(json["objects"].is_null());
  EXPECT_TRUE(json["masks"].is_null());
}

TEST(EvaluationJson, HasNoScoreOfAClassThatTheTruthDoesNotHave) {
  Evaluation evaluation = perfect_evaluation();
  evaluation.masks->classes[2].mots.fp = 183;
  const nlohmann::json json = json_of(evaluation);
  EXPECT_TRUE(json["masks"]["classes"]["pedestrian"]["smotsa"].is_null());
  EXPECT_EQ(json["masks"]["classes"]["pedestrian"]["fp"], 183);
  EXPECT_EQ(json["masks"]["classless"], false);
  EXPECT_THAT(evaluation_table(evaluation),
              AllOf(HasSubstr("none: the truth has no such mask, the run 183"), Not(HasSubstr("-18300"))));
}

TEST(EvaluationTable, SaysWhereMasksHaveNoClass) {
  Evaluation evaluation = perfect_evaluation();
  evaluation.masks->is_classless = true;
  EXPECT_THAT(evaluation_table(evaluation),
              AllOf(HasSubstr("whatever class"), HasSubstr("have no class"), Not(HasSubstr("all classes"))));
}

TEST(EvaluationTable, SaysNoneForWhatCouldNotBeMeasured) {
  EXPECT_THAT(evaluation_table({}), AllOf(HasSubstr("t_rel                          none"), HasSubstr("too short"),
                                          Not(HasSubstr("nan")), HasSubstr("Objects: none in the truth")));
}

TEST(EvaluationTable, NamesFalseMovingTracks) {
  Evaluation evaluation = perfect_evaluation();
  evaluation.objects->false_moving.push_back({7, 11, 17, 7, 2.5, 19});
  EXPECT_THAT(evaluation_table(evaluation),
              HasSubstr("track 7: 7 frames from 11 to 17 at 2.50 m/s, object 19 is at rest"));
}

TEST(EvaluationTable, HasARowForEachObject) {
  EXPECT_THAT(evaluation_table(perfect_evaluation()),
              AllOf(HasSubstr("\n       1 car         moving     20     20    100.0        0   0.0000"),
                    HasSubstr("\n       2 car         rest       20     20    100.0        0     none")));
}

TEST(ComparisonTable, HasFiguresOfBothRunsAndTheirRatios) {
  Evaluation run = perfect_evaluation();
  Evaluation against = perfect_evaluation();
  run.camera.t_rel_percent = 0.03;
  against.camera.t_rel_percent = 0.06;
  against.run = "before";
  const std::string table = comparison_table(run, against);
  EXPECT_THAT(table, AllOf(HasSubstr("Run:     run"), HasSubstr("Against: before")));
  EXPECT_THAT(table, ::testing::ContainsRegex("camera t_rel +0.03 +0.06 +0.50  %"));
}

TEST(ComparisonTable, SaysNoneOfWhatOneRunDoesNotHave) {
  Evaluation run = perfect_evaluation();
  const Evaluation against = perfect_evaluation();
  run.camera.t_rel_percent = std::nullopt;
  EXPECT_THAT(comparison_table(run, against), ::testing::ContainsRegex("camera t_rel +none"));
}

}  // namespace
}  // namespace kinetrace::evaluation
