#include "mask_clear.hpp"

#include <utility>

#include "kinetrace/evaluation/matching.hpp"

namespace kinetrace::evaluation {

// At 0.5 at most one mask matches, except for ties: those go to the track of the previous frame.
void ClearAccumulator::add(const MaskPairs& frame) {
  const auto truths = static_cast<std::int64_t>(frame.truth_ids.size());
  const auto results = static_cast<std::int64_t>(frame.result_ids.size());
  if (truths == 0 || results == 0) {
    scores_.fn += truths;
    scores_.fp += results;
    return;
  }
  constexpr double kSameTrack = 1000.0;
  Eigen::MatrixXd weights = (frame.iou.array() < kMotsIou - kRounding).select(0.0, frame.iou);
  for (Eigen::Index i = 0; i < weights.rows(); ++i) {
    const auto before = previous_match_.find(frame.truth_ids[static_cast<std::size_t>(i)]);
    for (Eigen::Index j = 0; j < weights.cols() && before != previous_match_.end(); ++j) {
      if (weights(i, j) > 0.0 && frame.result_ids[static_cast<std::size_t>(j)] == before->second) {
        weights(i, j) += kSameTrack;
      }
    }
  }
  const std::vector<int> match = best_matching(weights);
  std::map<std::int64_t, std::int64_t> matched;
  for (std::size_t i = 0; i < match.size(); ++i) {
    if (match[i] < 0) {
      continue;
    }
    const std::int64_t object = frame.truth_ids[i];
    const std::int64_t track = frame.result_ids[static_cast<std::size_t>(match[i])];
    const auto [last, is_new] = last_match_.try_emplace(object, track);
    scores_.id_switches += !is_new && last->second != track ? 1 : 0;
    last->second = track;
    matched.emplace(object, track);
    scores_.soft_tp += frame.iou(static_cast<Eigen::Index>(i), match[i]);
  }
  const auto hits = static_cast<std::int64_t>(matched.size());
  scores_.tp += hits;
  scores_.fn += truths - hits;
  scores_.fp += results - hits;
  previous_match_ = std::move(matched);
}

}  // namespace kinetrace::evaluation
