// Sequences of images one pixel high, drawn as text: '.' background, '#' ignore region, 'a' to 'z' instances of class
// 1, 'A' to 'Z' of class 2. Expected values are worked out by hand.
#include "kinetrace/evaluation/mask_metrics.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::evaluation {
namespace {

using ::testing::HasSubstr;

class Drawing {
 public:
  explicit Drawing(std::string_view text) {
    for (const char c : text) {
      const bool is_letter = std::isalpha(static_cast<unsigned char>(c)) != 0;
      const auto label = static_cast<std::uint8_t>(c == '#' ? kIgnoreLabel : is_letter ? c : kBackgroundLabel);
      labels_.push_back(label);
      const auto has_label = [&](const MaskInstance& instance) { return instance.label == label; };
      if (is_letter && std::none_of(instances_.begin(), instances_.end(), has_label)) {
        instances_.push_back({label, c, static_cast<std::uint16_t>(c >= 'a' ? 1 : 2)});
      }
    }
  }
  /// As regions found by motion.
  [[nodiscard]] Drawing without_classes() const {
    Drawing drawing = *this;
    for (MaskInstance& instance : drawing.instances_) {
      instance.class_id = kUnknownClass;
    }
    return drawing;
  }
  [[nodiscard]] InstanceMasks masks() const {
    const int width = static_cast<int>(labels_.size());
    return {{labels_.data(), width, 1, width}, instances_};
  }

 private:
  std::vector<std::uint8_t> labels_;
  std::vector<MaskInstance> instances_;
};

struct DrawnFrame {
  std::string_view truth;
  std::string_view result;
};

MaskReport evaluate(const std::vector<DrawnFrame>& frames) {
  MaskMetrics metrics;
  for (const DrawnFrame& frame : frames) {
    const Status added = metrics.add(Drawing(frame.truth).masks(), Drawing(frame.result).masks());
    EXPECT_TRUE(added) << added.error().message;
  }
  return metrics.report();
}

TEST(MaskMetrics, AreOneForTruthItself) {
  const MaskReport report = evaluate({{"aa..BB", "xx..YY"}, {".aaBB.", ".xxYY."}, {"..aa..", "..xx.."}});
  for (const MaskScores& scores : {report.classes.at(1), report.classes.at(2), report.combined, report.any_class}) {
    EXPECT_DOUBLE_EQ(scores.hota.hota(), 1.0);
    EXPECT_DOUBLE_EQ(scores.hota.deta(), 1.0);
    EXPECT_DOUBLE_EQ(scores.hota.assa(), 1.0);
    EXPECT_DOUBLE_EQ(scores.hota.loca(), 1.0);
    EXPECT_DOUBLE_EQ(scores.mots.motsa(), 1.0);
    EXPECT_DOUBLE_EQ(scores.mots.smotsa(), 1.0);
    EXPECT_DOUBLE_EQ(scores.mots.motsp(), 1.0);
  }
  EXPECT_EQ(report.combined.mots.tp, 5);
}

TEST(MaskMetrics, AreFiniteWithoutFrames) {
  const MaskScores scores = MaskMetrics().report().combined;
  EXPECT_EQ(scores.hota.hota(), 0.0);
  EXPECT_EQ(scores.hota.loca(), 1.0);
  EXPECT_EQ(scores.mots.motsa(), 0.0);
  EXPECT_EQ(scores.mots.motsp(), 0.0);
}

TEST(MaskMetrics, AnIdSwitchHalfwayHalvesAssociation) {
  const MaskScores scores = evaluate({{"aa", "xx"}, {"aa", "xx"}, {"aa", "yy"}, {"aa", "yy"}}).classes.at(1);
  EXPECT_DOUBLE_EQ(scores.hota.deta(), 1.0);
  EXPECT_DOUBLE_EQ(scores.hota.assa(), 0.5);  // TPA 2, FNA 2, FPA 0
  EXPECT_DOUBLE_EQ(scores.hota.assre(), 0.5);
  EXPECT_DOUBLE_EQ(scores.hota.asspr(), 1.0);
  EXPECT_DOUBLE_EQ(scores.hota.hota(), std::sqrt(0.5));
  EXPECT_EQ(scores.mots.id_switches, 1);
  EXPECT_DOUBLE_EQ(scores.mots.motsa(), 0.75);
  EXPECT_DOUBLE_EQ(scores.mots.smotsa(), 0.75);
}

TEST(MaskMetrics, OneTrackOnTwoObjectsLosesAssociationPrecision) {
  const MaskScores scores = evaluate({{"aa..", "xx.."}, {"..bb", "..xx"}}).classes.at(1);
  EXPECT_DOUBLE_EQ(scores.hota.assre(), 1.0);
  EXPECT_DOUBLE_EQ(scores.hota.asspr(), 0.5);
  EXPECT_DOUBLE_EQ(scores.hota.assa(), 0.5);
  EXPECT_EQ(scores.mots.id_switches, 0);
}

TEST(MaskMetrics, MissesLowerRecall) {
  const MaskScores scores = evaluate({{"aa", "xx"}, {"aa", "xx"}, {"aa", ".."}, {"aa", "xx"}}).classes.at(1);
  EXPECT_DOUBLE_EQ(scores.hota.detre(), 0.75);
  EXPECT_DOUBLE_EQ(scores.hota.detpr(), 1.0);
  EXPECT_DOUBLE_EQ(scores.hota.assa(), 0.75);
  EXPECT_DOUBLE_EQ(scores.hota.hota(), 0.75);
  EXPECT_EQ(scores.mots.fn, 1);
  EXPECT_EQ(scores.mots.id_switches, 0);
  EXPECT_DOUBLE_EQ(scores.mots.motsa(), 0.75);
}

TEST(MaskMetrics, FalsePositivesLowerPrecision) {
  const MaskScores scores =
      evaluate({{"aa..", "xxyy"}, {"aa..", "xxyy"}, {"aa..", "xx.."}, {"aa..", "xx.."}}).classes.at(1);
  EXPECT_DOUBLE_EQ(scores.hota.detpr(), 4.0 / 6.0);
  EXPECT_DOUBLE_EQ(scores.hota.deta(), 4.0 / 6.0);
  EXPECT_DOUBLE_EQ(scores.hota.assa(), 1.0);
  EXPECT_EQ(scores.mots.fp, 2);
  EXPECT_DOUBLE_EQ(scores.mots.motsa(), 0.5);
  EXPECT_DOUBLE_EQ(scores.mots.smotsa(), 0.5);
}

TEST(MaskMetrics, AResultWithoutTruthIsAllFalse) {
  const MaskScores scores = evaluate({{"..", "xx"}, {"..", "xx"}}).classes.at(1);
  EXPECT_EQ(scores.mots.fp, 2);
  EXPECT_DOUBLE_EQ(scores.mots.motsa(), -2.0);
  EXPECT_EQ(scores.hota.hota(), 0.0);
}

TEST(MaskMetrics, PartialOverlapCountsAtThresholdsUpToIt) {
  const MaskScores scores = evaluate({{"aaaa.", ".xxxx"}}).classes.at(1);  // 3 of 5: 12 of 19 thresholds
  EXPECT_DOUBLE_EQ(scores.hota.deta(), 12.0 / 19.0);
  EXPECT_DOUBLE_EQ(scores.hota.assa(), 12.0 / 19.0);
  EXPECT_DOUBLE_EQ(scores.hota.hota(), 12.0 / 19.0);
  EXPECT_NEAR(scores.hota.loca(), (12.0 * 0.6 + 7.0) / 19.0, 1e-12);
  EXPECT_DOUBLE_EQ(scores.mots.motsa(), 1.0);
  EXPECT_DOUBLE_EQ(scores.mots.smotsa(), 0.6);
  EXPECT_DOUBLE_EQ(scores.mots.motsp(), 0.6);
}

TEST(MaskMetrics, MotsMatchesAtOneHalfAndNotBelow) {
  EXPECT_EQ(evaluate({{"aaa.", ".xxx"}}).classes.at(1).mots.tp, 1);      // 2 of 4
  EXPECT_EQ(evaluate({{"aaaa..", "..xxx."}}).classes.at(1).mots.tp, 0);  // 2 of 5
  EXPECT_DOUBLE_EQ(evaluate({{"aaaa..", "..xxx."}}).classes.at(1).mots.motsa(), -1.0);
}

TEST(MaskMetrics, UnmatchedResultsMostlyWithinTheIgnoreRegionDoNotCount) {
  EXPECT_EQ(evaluate({{"..###.", "xxxxx."}}).any_class.mots.fp, 0);  // 3 of 5
  EXPECT_EQ(evaluate({{"..##..", "xxxx.."}}).any_class.mots.fp, 1);  // exactly half
  EXPECT_EQ(evaluate({{"..#...", "xxxx.."}}).any_class.mots.fp, 1);
  const MaskScores matched = evaluate({{"aaa##.", "xxxxx."}}).any_class;  // 3 of 5 matched
  EXPECT_EQ(matched.mots.tp, 1);
  // Removed masks do not count for HOTA either, even where they overlap truth.
  const MaskScores removed = evaluate({{"aa###.", ".xxxx."}}).any_class;
  EXPECT_EQ(removed.hota.thresholds[0].tp, 0.0);
  EXPECT_EQ(removed.hota.thresholds[0].fp, 0.0);
  EXPECT_EQ(removed.hota.thresholds[0].fn, 1.0);
}

TEST(MaskMetrics, HotaMatchesTheTrackThatFitsTheWholeSequence) {
  // In the last frame y covers more of a than x does, 0.6 to 0.4; but x matched a in all others.
  const MaskScores scores =
      evaluate({{"aaaaa", "xxxxx"}, {"aaaaa", "xxxxx"}, {"aaaaa", "xxxxx"}, {"aaaaa", "xxxxx"}, {"aaaaa", "xxyyy"}})
          .classes.at(1);
  const HotaAtThreshold& low = scores.hota.thresholds[7];  // 0.40
  EXPECT_EQ(low.tp, 5.0);
  EXPECT_EQ(low.fp, 1.0);
  EXPECT_DOUBLE_EQ(low.assa, 1.0);
  const HotaAtThreshold& high = scores.hota.thresholds[8];  // 0.45
  EXPECT_EQ(high.tp, 4.0);
  EXPECT_EQ(high.fn, 1.0);
  EXPECT_EQ(high.fp, 2.0);
  EXPECT_DOUBLE_EQ(high.assa, 4.0 / 6.0);  // TPA 4 of 5 + 5 - 4 masks
  EXPECT_EQ(scores.mots.tp, 5);            // (s)MOTSA matches within the frame alone.
  EXPECT_EQ(scores.mots.id_switches, 1);
}

TEST(MaskMetrics, ASwitchCountsAcrossAGapAndReturningCountsAgain) {
  EXPECT_EQ(evaluate({{"aa", "xx"}, {"aa", ".."}, {"aa", "yy"}}).any_class.mots.id_switches, 1);
  EXPECT_EQ(evaluate({{"aa", "xx"}, {"..", ".."}, {"aa", "xx"}}).any_class.mots.id_switches, 0);
  EXPECT_EQ(evaluate({{"aa", "xx"}, {"aa", "yy"}, {"aa", "xx"}}).any_class.mots.id_switches, 2);
}

TEST(MaskMetrics, TiesGoToTheTrackOfTheFrameBefore) {
  EXPECT_EQ(evaluate({{"aaaa", "xxxx"}, {"aaaa", "xxyy"}}).any_class.mots.id_switches, 0);
  EXPECT_EQ(evaluate({{"aaaa", "yyyy"}, {"aaaa", "xxyy"}}).any_class.mots.id_switches, 0);
}

TEST(MaskMetrics, AWrongClassMatchesOnlyWhereClassesAreDisregarded) {
  const MaskReport report = evaluate({{"aa", "XX"}});
  EXPECT_EQ(report.classes.at(1).mots.fn, 1);
  EXPECT_EQ(report.classes.at(2).mots.fp, 1);
  EXPECT_EQ(report.combined.mots.tp, 0);
  EXPECT_DOUBLE_EQ(report.combined.mots.motsa(), -1.0);
  EXPECT_EQ(report.combined.hota.hota(), 0.0);
  EXPECT_DOUBLE_EQ(report.any_class.hota.hota(), 1.0);
}

TEST(MaskMetrics, AResultWithoutClassesIsScoredWhateverTheClass) {
  MaskMetrics metrics;
  const Drawing truth("aaBB..");
  const Drawing result = Drawing("xxYYzz").without_classes();
  ASSERT_TRUE(metrics.add(truth.masks(), result.masks()));
  const MaskReport report = metrics.report();
  EXPECT_TRUE(report.is_classless);
  EXPECT_TRUE(report.classes.empty());
  EXPECT_EQ(report.combined.mots.tp, 2);
  EXPECT_EQ(report.combined.mots.fp, 1);
  EXPECT_DOUBLE_EQ(report.combined.mots.motsa(), 0.5);
  EXPECT_FALSE(evaluate({{"aa", "xx"}, {"..", ".."}}).is_classless);
  EXPECT_FALSE(evaluate({{"aa", ".."}}).is_classless) << "without a mask there is nothing to be without a class";
}

TEST(MaskMetrics, CombinedWeighsClassesByTheirMasks) {
  // Class 1: two masks, perfect. Class 2: four masks, switched halfway.
  const MaskReport report = evaluate({{"aaBB", "xxYY"}, {"aaBB", "xxYY"}, {"..BB", "..ZZ"}, {"..BB", "..ZZ"}});
  EXPECT_DOUBLE_EQ(report.combined.hota.assa(), (2.0 * 1.0 + 4.0 * 0.5) / 6.0);
  EXPECT_DOUBLE_EQ(report.combined.hota.asspr(), 1.0);
  EXPECT_DOUBLE_EQ(report.combined.hota.deta(), 1.0);
  EXPECT_DOUBLE_EQ(report.combined.mots.motsa(), 5.0 / 6.0);
}

TEST(MaskMetrics, AFrameThatIsRefusedDoesNotCount) {
  MaskMetrics metrics;
  ASSERT_TRUE(metrics.add(Drawing("aa").masks(), Drawing("xx").masks()));
  const Status refused = metrics.add(Drawing("aa").masks(), Drawing("xxx").masks());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("2 x 1 pixels in truth, 3 x 1 in the result"));
  EXPECT_EQ(metrics.report().combined.mots.tp + metrics.report().combined.mots.fn, 1);
}

TEST(MaskMetrics, AFrameWithoutResultImageIsMissed) {
  MaskMetrics metrics;
  ASSERT_TRUE(metrics.add(Drawing("aab").masks(), {}));
  EXPECT_EQ(metrics.report().any_class.mots.fn, 2);
}

TEST(MaskOverlap, HoldsTheIntersectionOverUnionOfEveryPair) {
  const auto overlap = overlap_masks(Drawing("aabbb.##").masks(), Drawing(".xxyyyyy").masks());
  ASSERT_TRUE(overlap) << overlap.error().message;
  EXPECT_EQ(overlap->iou.rows(), 2);
  EXPECT_EQ(overlap->iou.cols(), 2);
  EXPECT_DOUBLE_EQ(overlap->iou(0, 0), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(overlap->iou(0, 1), 0.0);
  EXPECT_DOUBLE_EQ(overlap->iou(1, 0), 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(overlap->iou(1, 1), 2.0 / 6.0);
  EXPECT_EQ(overlap->truth_area_px, Eigen::Vector2d(2.0, 3.0));
  EXPECT_EQ(overlap->result_area_px, Eigen::Vector2d(2.0, 5.0));
  EXPECT_EQ(overlap->ignored, Eigen::Vector2d(0.0, 0.4));
}

TEST(MaskOverlap, TakesInstancesWithoutPixels) {
  const std::vector<MaskInstance> unseen{{9, 1, 1}};
  const auto overlap = overlap_masks({Drawing("..").masks().labels, unseen}, {{}, unseen});
  ASSERT_TRUE(overlap);
  EXPECT_EQ(overlap->iou(0, 0), 0.0);
  EXPECT_EQ(overlap->ignored(0), 0.0);
}

TEST(MaskOverlap, RefusesLabelsAndIdsThatAreNotUnique) {
  const std::vector<std::vector<MaskInstance>> wrong{
      {{0, 1, 1}}, {{255, 1, 1}}, {{1, 1, 1}, {1, 2, 1}}, {{1, 5, 1}, {2, 5, 1}}};
  for (const std::vector<MaskInstance>& instances : wrong) {
    EXPECT_EQ(overlap_masks({{}, instances}, {}).error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(overlap_masks({}, {{}, instances}).error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(MotsImage, NumbersValuesAndKeepsTheIgnoreRegion) {
  const std::vector<std::uint16_t> pixels{0, 2003, 2003, 10000, 1001, 0};
  const auto image = label_mots_image({pixels.data(), 3, 2, 3});
  ASSERT_TRUE(image);
  EXPECT_EQ(image->labels, (std::vector<std::uint8_t>{0, 2, 2, 255, 1, 0}));
  ASSERT_EQ(image->instances.size(), 2U);
  EXPECT_EQ(image->instances[0].id, 1001);
  EXPECT_EQ(image->instances[0].class_id, 1);
  EXPECT_EQ(image->instances[1].id, 2003);
  EXPECT_EQ(image->instances[1].class_id, 2);
}

TEST(MotsImage, Takes254InstancesAndRefusesOneMore) {
  std::vector<std::uint16_t> pixels;
  for (std::uint16_t value = 1000; value < 1255; ++value) {
    pixels.push_back(value);
  }
  EXPECT_EQ(label_mots_image({pixels.data(), 254, 1, 254})->instances.back().label, 254);
  EXPECT_EQ(label_mots_image({pixels.data(), 255, 1, 255}).error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::evaluation
