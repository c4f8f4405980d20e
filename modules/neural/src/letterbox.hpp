// Conversion of a picture to the network's input tensor.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/neural/model.hpp"
#include "kinetrace/neural/picture.hpp"

namespace kinetrace::neural {

/// Placement of a picture in the network's input: input = picture * scale + offset, with pixel centres at halves.
struct Placement {
  double scale_x = 1.0;
  double scale_y = 1.0;
  int x0 = 0;  ///< Part of the input filled by the picture.
  int y0 = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] static Placement of(int width_px, int height_px, const ModelInput& input) noexcept;
  [[nodiscard]] double input_x(double picture_x) const noexcept { return picture_x * scale_x + x0; }
  [[nodiscard]] double input_y(double picture_y) const noexcept { return picture_y * scale_y + y0; }
  [[nodiscard]] double picture_x(double input_x) const noexcept { return (input_x - x0) / scale_x; }
  [[nodiscard]] double picture_y(double input_y) const noexcept { return (input_y - y0) / scale_y; }
};

/// Resamples pictures with a triangle filter as wide as a pixel of the coarser side, against aliasing.
class Letterbox {
 public:
  Letterbox() = default;
  Letterbox(const ModelInput& input, int max_width_px, int max_height_px, Arena& arena);

  /// Writes the tensor's colours, colour_channels() * height * width values. `picture` is at most as large as planned.
  void fill(const Picture& picture, const Placement& placement, std::span<float> tensor);
  /// Writes unscaled grey levels, height * width values.
  void fill_grey(const Picture& picture, const Placement& placement, std::span<float> plane);

 private:
  /// Samples and weights of a resampled line.
  struct Taps {
    int first = 0;
    int count = 0;
    int first_weight = 0;
  };
  struct Line {
    FixedVector<Taps> taps;
    FixedVector<float> weights;
  };
  static constexpr int kGrey = -1;

  static void set_line(Line& line, int from, int to) noexcept;
  void set_lines(const Picture& picture, const Placement& placement) noexcept;
  /// Channel kGrey: the luminance.
  void resample(const Picture& picture, int channel, const Placement& placement) noexcept;
  void put(float value_scale, float value_offset, const Placement& placement, float* plane) const noexcept;

  ModelInput input_;
  Line columns_;
  Line rows_;
  std::span<float> wide_;   ///< Picture's rows, input's columns.
  std::span<float> small_;  ///< The picture as the input has it.
};

}  // namespace kinetrace::neural
