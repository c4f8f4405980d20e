#include "mask_hota.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/evaluation/matching.hpp"

namespace kinetrace::evaluation {
namespace {

double threshold(std::size_t index) {
  constexpr double kStep = 0.05;
  return kStep * static_cast<double>(index + 1);
}

double ratio(double part, double whole) {
  return part / std::max(1.0, whole);
}

template <typename Value>
double mean(const std::array<HotaAtThreshold, kHotaThresholds>& thresholds, Value value) {
  double sum = 0.0;
  for (const HotaAtThreshold& at : thresholds) {
    sum += value(at);
  }
  return sum / static_cast<double>(kHotaThresholds);
}

}  // namespace

double HotaAtThreshold::deta() const noexcept {
  return ratio(tp, tp + fn + fp);
}
double HotaAtThreshold::detre() const noexcept {
  return ratio(tp, tp + fn);
}
double HotaAtThreshold::detpr() const noexcept {
  return ratio(tp, tp + fp);
}
double HotaAtThreshold::hota() const noexcept {
  return std::sqrt(deta() * assa);
}

double HotaScores::hota() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.hota(); });
}
double HotaScores::deta() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.deta(); });
}
double HotaScores::assa() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.assa; });
}
double HotaScores::loca() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.loca; });
}
double HotaScores::detre() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.detre(); });
}
double HotaScores::detpr() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.detpr(); });
}
double HotaScores::assre() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.assre; });
}
double HotaScores::asspr() const noexcept {
  return mean(thresholds, [](const HotaAtThreshold& at) { return at.asspr; });
}

std::uint32_t IdCounts::add(std::int64_t id) {
  const auto [entry, is_new] = index_of_id_.try_emplace(id, static_cast<std::uint32_t>(masks_.size()));
  if (is_new) {
    masks_.push_back(0.0);
  }
  masks_[entry->second] += 1.0;
  return entry->second;
}

void HotaAccumulator::add(const MaskPairs& pairs) {
  Frame frame;
  for (const std::int64_t id : pairs.truth_ids) {
    frame.truths.push_back(truths_.add(id));
  }
  for (const std::int64_t id : pairs.result_ids) {
    frame.results.push_back(results_.add(id));
  }
  const Eigen::VectorXd of_truth = pairs.iou.rowwise().sum();
  const Eigen::RowVectorXd of_result = pairs.iou.colwise().sum();
  for (Eigen::Index i = 0; i < pairs.iou.rows(); ++i) {
    for (Eigen::Index j = 0; j < pairs.iou.cols(); ++j) {
      const double iou = pairs.iou(i, j);
      if (iou > 0.0) {
        const Overlap overlap{static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), iou};
        frame.overlaps.push_back(overlap);
        potential_[{frame.truths[overlap.truth], frame.results[overlap.result]}] +=
            iou / (of_truth(i) + of_result(j) - iou);
      }
    }
  }
  frames_.push_back(std::move(frame));
}

// Agreement of two ids over the whole sequence: their Jaccard index.
double HotaAccumulator::alignment(const IdPair& pair) const {
  const double together = potential_.at(pair);
  return together / (truths_.masks(pair.first) + results_.masks(pair.second) - together);
}

std::vector<HotaAccumulator::Overlap> HotaAccumulator::matches(const Frame& frame) const {
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(frame.truths.size()),
                                                  static_cast<Eigen::Index>(frame.results.size()));
  for (const Overlap& overlap : frame.overlaps) {
    weights(overlap.truth, overlap.result) =
        overlap.iou * alignment({frame.truths[overlap.truth], frame.results[overlap.result]});
  }
  const std::vector<int> match = best_matching(weights);
  std::vector<Overlap> matched;
  std::copy_if(frame.overlaps.begin(), frame.overlaps.end(), std::back_inserter(matched),
               [&](const Overlap& overlap) { return match[overlap.truth] == static_cast<int>(overlap.result); });
  return matched;
}

HotaScores HotaAccumulator::scores() const {
  HotaScores scores;
  std::array<std::map<IdPair, double>, kHotaThresholds> matched_masks;
  std::array<double, kHotaThresholds> iou_sum{};
  for (const Frame& frame : frames_) {
    const std::vector<Overlap> matched = matches(frame);
    for (std::size_t k = 0; k < kHotaThresholds; ++k) {
      double hits = 0.0;
      for (const Overlap& overlap : matched) {
        if (overlap.iou >= threshold(k) - kRounding) {
          hits += 1.0;
          iou_sum[k] += overlap.iou;
          matched_masks[k][{frame.truths[overlap.truth], frame.results[overlap.result]}] += 1.0;
        }
      }
      HotaAtThreshold& at = scores.thresholds[k];
      at.tp += hits;
      at.fn += static_cast<double>(frame.truths.size()) - hits;
      at.fp += static_cast<double>(frame.results.size()) - hits;
    }
  }
  for (std::size_t k = 0; k < kHotaThresholds; ++k) {
    HotaAtThreshold& at = scores.thresholds[k];
    associate(matched_masks[k], at);
    at.loca = at.tp > 0.0 ? iou_sum[k] / at.tp : 1.0;
  }
  return scores;
}

// Each true positive of a pair of ids has the same association score.
void HotaAccumulator::associate(const std::map<IdPair, double>& matched_masks, HotaAtThreshold& at) const {
  for (const auto& [pair, tpa] : matched_masks) {
    const double of_truth = truths_.masks(pair.first);
    const double of_result = results_.masks(pair.second);
    at.assa += tpa * tpa / (of_truth + of_result - tpa);
    at.assre += tpa * tpa / of_truth;
    at.asspr += tpa * tpa / of_result;
  }
  at.assa = ratio(at.assa, at.tp);
  at.assre = ratio(at.assre, at.tp);
  at.asspr = ratio(at.asspr, at.tp);
}

}  // namespace kinetrace::evaluation
