// Disparities of a rectified pair as a channel of the network's input.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/model.hpp"
#include "runtime.hpp"

namespace kinetrace::neural {

/// Matches the pair at half the size of the input, and writes log2(1 + disparity / px) / 7 of its pixels: 0 far away or
/// unknown, about 1 at the largest disparity, of 127 px. The logarithm turns another baseline into an offset. The same
/// as apps/training/stereo.py.
class DisparityChannel {
 public:
  DisparityChannel() = default;
  DisparityChannel(const ModelInput& input, Arena& arena);

  /// `picture`, `other`: grey levels of the input's size; `view`: which camera `picture` is of. Errors: those of
  /// Runtime::match.
  [[nodiscard]] Status fill(std::span<const float> picture, std::span<const float> other, View view, Runtime& runtime,
                            std::span<float> channel);

 private:
  /// Writes means of 2x2 pixels. A mirrored right picture is a left one.
  void halve(std::span<const float> picture, bool is_mirrored, std::span<std::uint8_t> half) const noexcept;
  void write(bool is_mirrored, std::span<float> channel) const noexcept;

  int width_px_ = 0;  ///< Half of the input's.
  int height_px_ = 0;
  std::span<std::uint8_t> picture_;
  std::span<std::uint8_t> other_;
  std::span<std::int16_t> disparity_;
  std::span<float> value_of_;  ///< By raw disparity.
};

}  // namespace kinetrace::neural
