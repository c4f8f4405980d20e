// Reports masks that belong to other images.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "camera/health_monitor.hpp"
#include "camera/input_watch.hpp"
#include "config/input_config.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/segmentation/outline_contrast.hpp"

namespace kinetrace::app {

/// Compares the outlines of masks from outside the program with the images: masks of the right image, given as those of
/// the left one, invalidate all results, and `policy` decides whether they end the run; masks of other images are
/// reported. The first fault is reported once, and noted in health while it lasts.
class MaskFitWatch {
 public:
  /// `source`: the masks' origin, for messages, such as "mask folder masks/left".
  MaskFitWatch(InputPolicy policy, std::string source) : policy_(policy), source_(std::move(source)) {}

  /// Call after a frame. Allocates only to report a fault. Errors: kBadFormat (left and right masks are exchanged).
  [[nodiscard]] Status process(const FrameResult& result, HealthMonitor& health, const Warn& warn);

 private:
  enum class Fault : std::uint8_t { kExchanged, kUnrelated };

  void add(const FrameResult& result) noexcept;
  [[nodiscard]] std::optional<Fault> assess() const noexcept;

  InputPolicy policy_;
  std::string source_;
  std::uint64_t frames_missing_ = 0;  ///< Up to the last frame.
  std::int64_t last_ns_ = 0;
  segmentation::OutlineContrast recent_;  ///< Weighs earlier frames less.
  std::optional<Fault> reported_;         ///< The first one.
};

}  // namespace kinetrace::app
