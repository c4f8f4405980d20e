#include "heads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::neural {
namespace {

constexpr std::size_t kDistanceBins = 16;
constexpr std::size_t kAnchors = 3;
constexpr std::array<int, 3> kStrides{8, 16, 32};

float sigmoid(float x) noexcept {
  return 1.F / (1.F + std::exp(-x));
}
float logit(float p) noexcept {
  return std::log(p / (1.F - p));
}

struct BestClass {
  int index = 0;
  float value = 0.F;
};
BestClass best_of(const Strided& values, std::size_t count) noexcept {
  BestClass best{0, values[0]};
  for (std::size_t i = 1; i < count; ++i) {
    if (values[i] > best.value) {
      best = {static_cast<int>(i), values[i]};
    }
  }
  return best;
}

// Expectation of a distribution over bins (Li et al. 2020, generalized focal loss, eq. 4).
float expected_bin(const Strided& logits) noexcept {
  float largest = logits[0];
  for (std::size_t i = 1; i < kDistanceBins; ++i) {
    largest = std::max(largest, logits[i]);
  }
  float sum = 0.F;
  float weighted = 0.F;
  for (std::size_t i = 0; i < kDistanceBins; ++i) {
    const float weight = std::exp(logits[i] - largest);
    sum += weight;
    weighted += weight * static_cast<float>(i);
  }
  return weighted / sum;
}

class Decoder {
 public:
  Decoder(const HeadLayout& layout, const ModelConfig& model, std::span<const Tensor> outputs,
          CandidateList& candidates) noexcept
      : layout_(layout), model_(model), outputs_(outputs), candidates_(candidates), classes_(model.classes.size()) {
    for (const ModelClass& one : model_.classes) {
      weakest_ = std::min(weakest_, least_score(one));
    }
  }

  void decode() noexcept {
    switch (layout_.kind) {
      case HeadLayout::Kind::kColumns: return decode_columns();
      case HeadLayout::Kind::kRows: return decode_rows();
      case HeadLayout::Kind::kDistanceMaps: return decode_levels(&Decoder::decode_distances);
      case HeadLayout::Kind::kCellMaps: return decode_levels(&Decoder::decode_cells);
      case HeadLayout::Kind::kAnchorMaps: return decode_levels(&Decoder::decode_anchors);
      case HeadLayout::Kind::kDetections: return decode_detections();
    }
  }

 private:
  struct Level {
    std::size_t index = 0;
    std::size_t width = 0;
    std::size_t height = 0;
    std::size_t first_cell = 0;  ///< Index over the cells of all levels.
  };

  [[nodiscard]] float least_score(const ModelClass& one) const noexcept {
    switch (one.class_id) {
      case ModelClass::kDropped: return std::numeric_limits<float>::infinity();
      case kIgnoreClass: return one.min_score;
      default: return std::min(one.min_score, one.calibration.score(model_.thresholds.proposal));
    }
  }
  [[nodiscard]] bool is_wanted(int class_index, float score) const noexcept {
    return score >= weakest_ && score >= least_score(model_.classes[static_cast<std::size_t>(class_index)]);
  }
  void add(const Box& box, float score, int class_index, Strided mask) noexcept {
    if (is_wanted(class_index, score)) {
      candidates_.add({box, score, class_index, mask});
    }
  }

  void decode_columns() noexcept {
    const Tensor& output = outputs_[layout_.boxes[0]];
    const auto count = static_cast<std::size_t>(output.sizes[2]);
    const auto step = static_cast<std::ptrdiff_t>(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Strided column{output.values.data() + i, step};
      const BestClass best = best_of({&column.first[4 * step], step}, classes_);
      add(Box::around(column[0], column[1], column[2], column[3]), best.value, best.index,
          {&column.first[static_cast<std::ptrdiff_t>(4 + classes_) * step], step});
    }
  }

  void decode_rows() noexcept {
    const Tensor& output = outputs_[layout_.boxes[0]];
    const auto length = static_cast<std::size_t>(output.sizes[2]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(output.sizes[1]); ++i) {
      const float* row = output.values.data() + i * length;
      if (row[4] < weakest_) {
        continue;
      }
      const BestClass best = best_of({row + 5, 1}, classes_);
      add(Box::around(row[0], row[1], row[2], row[3]), row[4] * best.value, best.index, {row + 5 + classes_, 1});
    }
  }

  void decode_levels(void (Decoder::*decode_level)(const Level&) noexcept) noexcept {
    Level level;
    for (level.index = 0; level.index < layout_.levels; ++level.index) {
      level.width = static_cast<std::size_t>(model_.input.width_px / kStrides[level.index]);
      level.height = static_cast<std::size_t>(model_.input.height_px / kStrides[level.index]);
      (this->*decode_level)(level);
      level.first_cell += level.width * level.height;
    }
  }

  void decode_distances(const Level& level) noexcept {
    const Tensor& map = outputs_[layout_.boxes[level.index]];
    const Tensor& coefficients = outputs_[layout_.coefficients];
    const std::size_t cells = level.width * level.height;
    const auto step = static_cast<std::ptrdiff_t>(cells);
    const auto stride = static_cast<float>(kStrides[level.index]);
    const float wanted = logit(std::clamp(weakest_, 1e-6F, 1.F - 1e-6F));
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const float* first = map.values.data() + cell;
      const BestClass best = best_of({first + static_cast<std::ptrdiff_t>(4 * kDistanceBins) * step, step}, classes_);
      if (best.value < wanted) {
        continue;
      }
      std::array<float, 4> distance{};  // To the left, top, right and bottom.
      for (std::size_t side = 0; side < 4; ++side) {
        distance[side] = expected_bin({first + static_cast<std::ptrdiff_t>(side * kDistanceBins) * step, step});
      }
      const std::size_t row = cell / level.width;
      const float x = static_cast<float>(cell % level.width) + 0.5F;
      const float y = static_cast<float>(row) + 0.5F;
      add({(x - distance[0]) * stride, (y - distance[1]) * stride, (x + distance[2]) * stride,
           (y + distance[3]) * stride},
          sigmoid(best.value), best.index,
          {coefficients.values.data() + level.first_cell + cell, coefficients.sizes[2]});
    }
  }

  void decode_cells(const Level& level) noexcept {
    const Tensor& map = outputs_[layout_.boxes[level.index]];
    const std::size_t cells = level.width * level.height;
    const auto step = static_cast<std::ptrdiff_t>(cells);
    const auto stride = static_cast<float>(kStrides[level.index]);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const Strided distance{map.values.data() + cell, step};  // To the left, top, right and bottom.
      const float* scores = distance.first + 4 * step;
      const BestClass best = best_of({scores, step}, classes_);
      const std::size_t row = cell / level.width;
      const float x = (static_cast<float>(cell % level.width) + 0.5F) * stride;
      const float y = (static_cast<float>(row) + 0.5F) * stride;
      add({x - distance[0], y - distance[1], x + distance[2], y + distance[3]}, best.value, best.index,
          {scores + static_cast<std::ptrdiff_t>(classes_) * step, step});
    }
  }

  // Ultralytics YOLOv5: https://docs.ultralytics.com/yolov5/tutorials/architecture_description, "Eliminate grid
  // sensitivity".
  void decode_anchors(const Level& level) noexcept {
    const Tensor& map = outputs_[layout_.boxes[level.index]];
    const auto length = static_cast<std::size_t>(map.sizes[4]);
    const auto stride = static_cast<float>(kStrides[level.index]);
    const float wanted = logit(std::clamp(weakest_, 1e-6F, 1.F - 1e-6F));
    const std::size_t cells = level.width * level.height;
    for (std::size_t i = 0; i < kAnchors * cells; ++i) {
      const float* row = map.values.data() + i * length;
      if (row[4] < wanted) {
        continue;
      }
      const BestClass best = best_of({row + 5, 1}, classes_);
      const std::size_t cell = i % cells;
      const std::size_t cell_row = cell / level.width;
      const float* anchor = &model_.anchors_px[(level.index * kAnchors + i / cells) * 2];
      const float x = (2.F * sigmoid(row[0]) - 0.5F + static_cast<float>(cell % level.width)) * stride;
      const float y = (2.F * sigmoid(row[1]) - 0.5F + static_cast<float>(cell_row)) * stride;
      const float width = 4.F * sigmoid(row[2]) * sigmoid(row[2]) * anchor[0];
      const float height = 4.F * sigmoid(row[3]) * sigmoid(row[3]) * anchor[1];
      add(Box::around(x, y, width, height), sigmoid(row[4]) * sigmoid(best.value), best.index, {row + 5 + classes_, 1});
    }
  }

  void decode_detections() noexcept {
    const Tensor& rows = outputs_[layout_.boxes[0]];
    const Tensor& masks = outputs_[layout_.masks];
    const auto width = static_cast<float>(model_.input.width_px);
    const auto height = static_cast<float>(model_.input.height_px);
    const std::size_t mask_size =
        static_cast<std::size_t>(layout_.mask_width) * static_cast<std::size_t>(layout_.mask_height);
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows.sizes[2]); ++i) {
      const float* row = rows.values.data() + i * 7;
      const int class_index = static_cast<int>(row[1]);
      if (!(row[1] >= 0.F) || class_index >= static_cast<int>(classes_)) {
        continue;
      }
      const std::size_t mask = i * classes_ + static_cast<std::size_t>(class_index);
      add({row[3] * width, row[4] * height, row[5] * width, row[6] * height}, row[2], class_index,
          {masks.values.data() + mask * mask_size, 1});
    }
  }

  const HeadLayout& layout_;
  const ModelConfig& model_;
  std::span<const Tensor> outputs_;
  CandidateList& candidates_;
  std::size_t classes_;
  float weakest_ = std::numeric_limits<float>::infinity();  ///< Least score threshold of the classes in use.
};

}  // namespace

void decode(const HeadLayout& layout, const ModelConfig& model, std::span<const Tensor> outputs,
            CandidateList& candidates) noexcept {
  Decoder(layout, model, outputs, candidates).decode();
}

}  // namespace kinetrace::neural
