// Layout and decoding of a network's outputs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "candidates.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/model.hpp"
#include "runtime.hpp"

namespace kinetrace::neural {

/// Strides of the prototypes in pixels of the input: exported YOLO, and Kinetrace's own networks.
inline constexpr std::array<int, 2> kPrototypeStrides_px{4, 2};

/// Roles of the outputs, found once by their shapes. Channel counts: C classes, M mask coefficients, K classes and
/// masks.
struct HeadLayout {
  enum class Kind : std::uint8_t {
    kColumns,       ///< [1, 4 + C + M, N]: YOLOv8 and 11 as exported.
    kRows,          ///< [1, N, 5 + C + M]: YOLOv5 as exported.
    kDistanceMaps,  ///< Per level [1, 4 * 16 + C, h, w], and [1, M, N]: YOLOv8 and 11, raw.
    kCellMaps,      ///< Per level [1, 4 + C + M, h, w]: Kinetrace's own.
    kAnchorMaps,    ///< Per level [1, 3, h, w, 5 + C + M]: YOLOv5, raw.
    kDetections,    ///< [1, 1, N, 7] and [N, C, h, w]: Mask R-CNN.
  };

  Kind kind = Kind::kColumns;
  std::array<std::size_t, 3> boxes{};  ///< Indices of outputs; the first, or one per level.
  std::size_t levels = 1;
  std::size_t coefficients = 0;  ///< Output of kDistanceMaps.
  std::size_t masks = 0;         ///< Output with prototypes [1, M, h, w], or the masks of kDetections.
  int mask_count = 0;            ///< M.
  int mask_width = 0;            ///< Of the prototypes or masks.
  int mask_height = 0;
  int prototype_stride_px = kPrototypeStrides_px[0];

  /// Errors: kUnsupported if no layout of the family fits, kInvalidConfig if the number of classes does not; with the
  /// shapes found and expected.
  [[nodiscard]] static Result<HeadLayout> find(const ModelConfig& model, std::span<const Tensor> outputs);
};

/// Adds every box whose score reaches the threshold.
void decode(const HeadLayout& layout, const ModelConfig& model, std::span<const Tensor> outputs,
            CandidateList& candidates) noexcept;

}  // namespace kinetrace::neural
