// Interface to the library that computes networks. Implementations are plugins.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/model.hpp"

namespace kinetrace::neural {

/// Dense values, the last dimension running fastest.
struct Tensor {
  static constexpr std::size_t kMaxRank = 5;

  std::span<const float> values;
  std::array<int, kMaxRank> sizes{};
  std::size_t rank = 0;

  [[nodiscard]] std::span<const int> shape() const noexcept { return std::span(sizes).first(rank); }
};

class Runtime {
 public:
  Runtime() = default;
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;
  virtual ~Runtime() = default;

  /// `input`: [1, channels, height, width] as the model describes it. The outputs live until the next call. Errors:
  /// kUnsupported, with the library's reason.
  [[nodiscard]] virtual Result<std::span<const Tensor>> run(std::span<const float> input) = 0;

  /// Largest disparity that is searched for, and the unit, one pixel is so many.
  static constexpr int kDisparityFraction = 16;
  static constexpr int kMaxDisparity = 64 * kDisparityFraction;
  /// Dense disparities of the left one of two rectified images `width_px` wide; at most kMaxDisparity, where unknown at
  /// most 0. Errors: as above.
  [[nodiscard]] virtual Status match(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                                     int width_px, std::span<std::int16_t> disparity) = 0;
};

/// Errors: kNotFound, kBadFormat, kUnsupported (operators).
using MakeRuntime = Result<std::unique_ptr<Runtime>> (*)(const ModelConfig& model, int threads);

/// Exported by a plugin under the name kRuntimePluginSymbol.
using RuntimePlugin = MakeRuntime (*)();
inline constexpr const char* kRuntimePluginSymbol = "kinetrace_runtime_plugin";

/// Loads a plugin; empty: see NetworkOptions::runtime. Errors: kUnsupported, naming the plugin and the remedy.
[[nodiscard]] Result<MakeRuntime> load_runtime(const std::string& plugin);

}  // namespace kinetrace::neural
