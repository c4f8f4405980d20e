#include "disparity_channel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kinetrace::neural {
namespace {

constexpr int kReduction = 2;
constexpr float kOctaves = 7.F;

}  // namespace

DisparityChannel::DisparityChannel(const ModelInput& input, Arena& arena)
    : width_px_(input.width_px / kReduction), height_px_(input.height_px / kReduction) {
  const std::size_t pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  picture_ = arena.take<std::uint8_t>(pixels);
  other_ = arena.take<std::uint8_t>(pixels);
  disparity_ = arena.take<std::int16_t>(pixels);
  value_of_ = arena.take<float>(std::size_t{Runtime::kMaxDisparity} + 1);
  for (std::size_t raw = 0; raw < value_of_.size(); ++raw) {
    const float disparity_px = static_cast<float>(raw) * kReduction / Runtime::kDisparityFraction;
    value_of_[raw] = std::log2(1.F + disparity_px) / kOctaves;
  }
}

Status DisparityChannel::fill(std::span<const float> picture, std::span<const float> other, View view, Runtime& runtime,
                              std::span<float> channel) {
  const bool is_mirrored = view == View::kRight;
  halve(picture, is_mirrored, picture_);
  halve(other, is_mirrored, other_);
  if (Status matched = runtime.match(picture_, other_, width_px_, disparity_); !matched) {
    return matched;
  }
  write(is_mirrored, channel);
  return {};
}

void DisparityChannel::halve(std::span<const float> picture, bool is_mirrored,
                             std::span<std::uint8_t> half) const noexcept {
  const auto width = static_cast<std::size_t>(width_px_);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_px_); ++y) {
    const float* const above = picture.data() + kReduction * y * kReduction * width;
    const float* const below = above + kReduction * width;
    std::uint8_t* const row = half.data() + y * width;
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t at = kReduction * x;
      const float mean = 0.25F * (above[at] + above[at + 1] + below[at] + below[at + 1]);
      row[x] = static_cast<std::uint8_t>(std::lround(std::clamp(mean, 0.F, 255.F)));
    }
    if (is_mirrored) {
      std::reverse(row, row + width);
    }
  }
}

void DisparityChannel::write(bool is_mirrored, std::span<float> channel) const noexcept {
  const auto width = static_cast<std::size_t>(width_px_);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_px_); ++y) {
    const std::int16_t* const from = disparity_.data() + y * width;
    float* const above = channel.data() + kReduction * y * kReduction * width;
    for (std::size_t x = 0; x < width; ++x) {
      const int raw = std::clamp<int>(from[is_mirrored ? width - 1 - x : x], 0, Runtime::kMaxDisparity);
      above[kReduction * x] = above[kReduction * x + 1] = value_of_[static_cast<std::size_t>(raw)];
    }
    std::copy_n(above, kReduction * width, above + kReduction * width);
  }
}

}  // namespace kinetrace::neural
