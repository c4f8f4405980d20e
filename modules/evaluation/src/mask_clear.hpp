// MOTSA and sMOTSA of one class.
#pragma once

#include <map>

#include "kinetrace/evaluation/mask_metrics.hpp"
#include "mask_sequence.hpp"

namespace kinetrace::evaluation {

class ClearAccumulator {
 public:
  void add(const MaskPairs& frame);
  [[nodiscard]] const MotsScores& scores() const noexcept { return scores_; }

 private:
  MotsScores scores_;
  std::map<std::int64_t, std::int64_t> last_match_;      ///< Track of each object's last match.
  std::map<std::int64_t, std::int64_t> previous_match_;  ///< ... in the previous frame.
};

}  // namespace kinetrace::evaluation
