// HOTA of one class.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "kinetrace/evaluation/mask_metrics.hpp"
#include "mask_sequence.hpp"

namespace kinetrace::evaluation {

/// Numbers ids in the order of their first appearance and counts their masks.
class IdCounts {
 public:
  std::uint32_t add(std::int64_t id);
  [[nodiscard]] double masks(std::uint32_t index) const { return masks_[index]; }

 private:
  std::map<std::int64_t, std::uint32_t> index_of_id_;
  std::vector<double> masks_;
};

class HotaAccumulator {
 public:
  void add(const MaskPairs& frame);
  [[nodiscard]] HotaScores scores() const;

 private:
  struct Overlap {
    std::uint32_t truth;  ///< Index within the frame.
    std::uint32_t result;
    double iou;
  };
  struct Frame {
    std::vector<std::uint32_t> truths;  ///< Index of each mask's id.
    std::vector<std::uint32_t> results;
    std::vector<Overlap> overlaps;  ///< Those above zero.
  };
  using IdPair = std::pair<std::uint32_t, std::uint32_t>;  ///< Truth, result.
  [[nodiscard]] std::vector<Overlap> matches(const Frame& frame) const;
  [[nodiscard]] double alignment(const IdPair& pair) const;
  void associate(const std::map<IdPair, double>& matched_masks, HotaAtThreshold& at) const;

  IdCounts truths_;
  IdCounts results_;
  std::map<IdPair, double> potential_;  ///< Sum over the frames of the overlap relative to all overlaps of the two.
  std::vector<Frame> frames_;
};

}  // namespace kinetrace::evaluation
