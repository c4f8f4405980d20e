#include "kinetrace/evaluation/mask_metrics.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/evaluation/matching.hpp"
#include "mask_clear.hpp"
#include "mask_hota.hpp"
#include "mask_sequence.hpp"

namespace kinetrace::evaluation {
namespace {

using OptionalClass = std::optional<std::uint16_t>;

std::vector<Eigen::Index> members(std::span<const MaskInstance> instances, OptionalClass class_id) {
  std::vector<Eigen::Index> indices;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (!class_id || instances[i].class_id == *class_id) {
      indices.push_back(static_cast<Eigen::Index>(i));
    }
  }
  return indices;
}

/// `results` without false positives that lie mostly in the ignore region.
std::vector<Eigen::Index> counted(const std::vector<Eigen::Index>& truths, const std::vector<Eigen::Index>& results,
                                  const MaskOverlap& overlap) {
  const Eigen::MatrixXd iou = overlap.iou(truths, results);
  const std::vector<int> match = best_matching((iou.array() < kMotsIou - kRounding).select(0.0, iou));
  std::vector<Eigen::Index> kept;
  for (std::size_t j = 0; j < results.size(); ++j) {
    const bool matched = std::find(match.begin(), match.end(), static_cast<int>(j)) != match.end();
    if (matched || overlap.ignored(results[j]) <= kMotsIou + kRounding) {
      kept.push_back(results[j]);
    }
  }
  return kept;
}

std::vector<std::int64_t> ids(std::span<const MaskInstance> instances, const std::vector<Eigen::Index>& indices) {
  std::vector<std::int64_t> values;
  values.reserve(indices.size());
  for (const Eigen::Index i : indices) {
    values.push_back(instances[static_cast<std::size_t>(i)].id);
  }
  return values;
}

/// The scores of one class, or of all masks without regard to class.
struct Accumulator {
  HotaAccumulator hota;
  ClearAccumulator clear;

  void add(OptionalClass class_id, const InstanceMasks& truth, const InstanceMasks& result,
           const MaskOverlap& overlap) {
    const std::vector<Eigen::Index> truths = members(truth.instances, class_id);
    const std::vector<Eigen::Index> results = counted(truths, members(result.instances, class_id), overlap);
    const MaskPairs pairs{ids(truth.instances, truths), ids(result.instances, results), overlap.iou(truths, results)};
    hota.add(pairs);
    clear.add(pairs);
  }
  [[nodiscard]] MaskScores scores() const { return {hota.scores(), clear.scores()}; }
};

MotsScores operator+(const MotsScores& a, const MotsScores& b) {
  return {a.tp + b.tp, a.fn + b.fn, a.fp + b.fp, a.id_switches + b.id_switches, a.soft_tp + b.soft_tp};
}

// Association and localisation are means over true positives.
HotaAtThreshold operator+(const HotaAtThreshold& a, const HotaAtThreshold& b) {
  HotaAtThreshold sum{a.tp + b.tp, a.fn + b.fn, a.fp + b.fp};
  if (sum.tp > 0.0) {
    const auto mean = [&](double HotaAtThreshold::*score) { return (a.tp * a.*score + b.tp * b.*score) / sum.tp; };
    sum.assa = mean(&HotaAtThreshold::assa);
    sum.assre = mean(&HotaAtThreshold::assre);
    sum.asspr = mean(&HotaAtThreshold::asspr);
    sum.loca = mean(&HotaAtThreshold::loca);
  }
  return sum;
}

}  // namespace

double MotsScores::motsa() const noexcept {
  return static_cast<double>(tp - fp - id_switches) / static_cast<double>(std::max<std::int64_t>(1, tp + fn));
}
double MotsScores::smotsa() const noexcept {
  return (soft_tp - static_cast<double>(fp + id_switches)) / static_cast<double>(std::max<std::int64_t>(1, tp + fn));
}
double MotsScores::motsp() const noexcept {
  return soft_tp / static_cast<double>(std::max<std::int64_t>(1, tp));
}

struct MaskMetrics::Impl {
  std::map<std::uint16_t, Accumulator> classes;
  Accumulator any_class;
  bool has_masks = false;  ///< Whether the result has had any so far.
  bool knows_classes = false;
};

MaskMetrics::MaskMetrics() : impl_(std::make_unique<Impl>()) {}
MaskMetrics::MaskMetrics(MaskMetrics&&) noexcept = default;
MaskMetrics& MaskMetrics::operator=(MaskMetrics&&) noexcept = default;
MaskMetrics::~MaskMetrics() = default;

Status MaskMetrics::add(const InstanceMasks& truth, const InstanceMasks& result) {
  const Result<MaskOverlap> overlap = overlap_masks(truth, result);
  if (!overlap) {
    return Unexpected(overlap.error());
  }
  for (const auto& instances : {truth.instances, result.instances}) {
    for (const MaskInstance& instance : instances) {
      impl_->classes.try_emplace(instance.class_id);
    }
  }
  for (const MaskInstance& instance : result.instances) {
    impl_->has_masks = true;
    impl_->knows_classes = impl_->knows_classes || instance.class_id != kUnknownClass;
  }
  for (auto& [class_id, accumulator] : impl_->classes) {
    accumulator.add(class_id, truth, result, *overlap);
  }
  impl_->any_class.add(std::nullopt, truth, result, *overlap);
  return {};
}

MaskReport MaskMetrics::report() const {
  MaskReport report;
  report.any_class = impl_->any_class.scores();
  report.is_classless = impl_->has_masks && !impl_->knows_classes;
  if (report.is_classless) {
    report.combined = report.any_class;
    return report;
  }
  for (const auto& [class_id, accumulator] : impl_->classes) {
    const MaskScores scores = accumulator.scores();
    report.combined.mots = report.combined.mots + scores.mots;
    for (std::size_t k = 0; k < kHotaThresholds; ++k) {
      HotaAtThreshold& sum = report.combined.hota.thresholds[k];
      sum = sum + scores.hota.thresholds[k];
    }
    report.classes.emplace(class_id, scores);
  }
  return report;
}

}  // namespace kinetrace::evaluation
