#include "letterbox.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kinetrace::neural {
namespace {

// Upper bound of the weights for a line of n samples, at any scale.
std::size_t weight_capacity(int from, int to) {
  return 2 * static_cast<std::size_t>(from) + 4 * static_cast<std::size_t>(to) + 4;
}

// ITU-R BT.601.
float luminance(const std::uint8_t* rgb) noexcept {
  return 0.299F * static_cast<float>(rgb[0]) + 0.587F * static_cast<float>(rgb[1]) +
         0.114F * static_cast<float>(rgb[2]);
}

}  // namespace

Placement Placement::of(int width_px, int height_px, const ModelInput& input) noexcept {
  Placement placement;
  placement.scale_x = static_cast<double>(input.width_px) / width_px;
  placement.scale_y = static_cast<double>(input.height_px) / height_px;
  if (input.fit == InputFit::kLetterbox) {
    placement.scale_x = placement.scale_y = std::min(placement.scale_x, placement.scale_y);
  }
  const auto filled = [](int size, double scale, int available) {
    return std::clamp(static_cast<int>(std::lround(size * scale)), 1, available);
  };
  placement.width = filled(width_px, placement.scale_x, input.width_px);
  placement.height = filled(height_px, placement.scale_y, input.height_px);
  placement.scale_x = static_cast<double>(placement.width) / width_px;
  placement.scale_y = static_cast<double>(placement.height) / height_px;
  placement.x0 = (input.width_px - placement.width) / 2;
  placement.y0 = (input.height_px - placement.height) / 2;
  return placement;
}

Letterbox::Letterbox(const ModelInput& input, int max_width_px, int max_height_px, Arena& arena) : input_(input) {
  const auto take_line = [&](int from, int to) {
    return Line{FixedVector<Taps>(arena, static_cast<std::size_t>(to)),
                FixedVector<float>(arena, weight_capacity(from, to))};
  };
  columns_ = take_line(max_width_px, input.width_px);
  rows_ = take_line(max_height_px, input.height_px);
  wide_ = arena.take<float>(static_cast<std::size_t>(max_height_px) * static_cast<std::size_t>(input.width_px));
  small_ = arena.take<float>(static_cast<std::size_t>(input.height_px) * static_cast<std::size_t>(input.width_px));
}

void Letterbox::set_line(Line& line, int from, int to) noexcept {
  line.taps.clear();
  line.weights.clear();
  const double step = static_cast<double>(from) / to;
  const double reach = std::max(1.0, step);
  for (int i = 0; i < to; ++i) {
    const double centre = (i + 0.5) * step - 0.5;
    const int first = std::clamp(static_cast<int>(std::ceil(centre - reach + 1e-9)), 0, from - 1);
    const int last = std::clamp(static_cast<int>(std::floor(centre + reach - 1e-9)), first, from - 1);
    const Taps taps{first, last - first + 1, static_cast<int>(line.weights.size())};
    double sum = 0.0;
    for (int j = first; j <= last; ++j) {
      sum += std::max(1e-6, 1.0 - std::abs(j - centre) / reach);
    }
    for (int j = first; j <= last; ++j) {
      static_cast<void>(
          line.weights.push_back(static_cast<float>(std::max(1e-6, 1.0 - std::abs(j - centre) / reach) / sum)));
    }
    static_cast<void>(line.taps.push_back(taps));
  }
}

void Letterbox::resample(const Picture& picture, int channel, const Placement& placement) noexcept {
  const bool mixes = picture.channels == 3 && channel == kGrey;
  const std::ptrdiff_t step = picture.channels;
  const std::ptrdiff_t shift = picture.channels == 3 && !mixes ? channel : 0;
  const auto width = static_cast<std::size_t>(placement.width);
  for (int y = 0; y < picture.height_px; ++y) {
    const std::uint8_t* row = picture.row(y);
    float* target = wide_.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) {
      const Taps& taps = columns_.taps[x];
      const float* weight = &columns_.weights[static_cast<std::size_t>(taps.first_weight)];
      float sum = 0.F;
      for (int i = 0; i < taps.count; ++i) {
        const std::uint8_t* sample = row + (taps.first + i) * step;
        sum += weight[i] * (mixes ? luminance(sample) : static_cast<float>(sample[shift]));
      }
      target[x] = sum;
    }
  }
  for (std::size_t y = 0; y < static_cast<std::size_t>(placement.height); ++y) {
    const Taps& taps = rows_.taps[y];
    float* target = small_.data() + y * width;
    std::fill_n(target, width, 0.F);
    for (std::size_t i = 0; i < static_cast<std::size_t>(taps.count); ++i) {
      const float weight = rows_.weights[static_cast<std::size_t>(taps.first_weight) + i];
      const float* source = wide_.data() + (static_cast<std::size_t>(taps.first) + i) * width;
      for (std::size_t x = 0; x < width; ++x) {
        target[x] += weight * source[x];
      }
    }
  }
}

void Letterbox::put(float value_scale, float value_offset, const Placement& placement, float* plane) const noexcept {
  const std::size_t plane_size = static_cast<std::size_t>(input_.width_px) * static_cast<std::size_t>(input_.height_px);
  std::fill_n(plane, plane_size, static_cast<float>(input_.pad) * value_scale + value_offset);
  for (int y = 0; y < placement.height; ++y) {
    const float* source = small_.data() + static_cast<std::ptrdiff_t>(y) * placement.width;
    float* target = plane + static_cast<std::ptrdiff_t>(placement.y0 + y) * input_.width_px + placement.x0;
    std::transform(source, source + placement.width, target,
                   [=](float value) { return value * value_scale + value_offset; });
  }
}

void Letterbox::set_lines(const Picture& picture, const Placement& placement) noexcept {
  set_line(columns_, picture.width_px, placement.width);
  set_line(rows_, picture.height_px, placement.height);
}

void Letterbox::fill_grey(const Picture& picture, const Placement& placement, std::span<float> plane) {
  set_lines(picture, placement);
  resample(picture, kGrey, placement);
  put(1.F, 0.F, placement, plane.data());
}

void Letterbox::fill(const Picture& picture, const Placement& placement, std::span<float> tensor) {
  set_lines(picture, placement);
  const std::size_t plane = static_cast<std::size_t>(input_.width_px) * static_cast<std::size_t>(input_.height_px);
  const bool is_grey = picture.channels == 1;
  for (int i = 0; i < input_.colour_channels(); ++i) {
    if (i == 0 || !is_grey) {  // A grey picture fills all three channels of a colour network.
      const int colour = input_.colours == InputColours::kBgr ? 2 - i : i;
      resample(picture, input_.colours == InputColours::kGray ? kGrey : colour, placement);
    }
    const auto channel = static_cast<std::size_t>(i);
    put(input_.scale / input_.deviation[channel], -input_.mean[channel] / input_.deviation[channel], placement,
        tensor.data() + channel * plane);
  }
}

}  // namespace kinetrace::neural
