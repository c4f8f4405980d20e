// Converts captured bytes to 8-bit luminance.
#pragma once

#include <cstddef>
#include <memory>

#include "capture/capture_device.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// Returns 8-bit luminance rows (GREY, NV12) in place; converts other formats into an image of its own from the arena.
/// One reader serves one device and one thread.
class LuminanceReader {
 public:
  [[nodiscard]] static std::size_t required_bytes(const CaptureConfig& config);
  /// Errors: kCapacity (arena too small), kUnsupported (a format this build cannot decode).
  [[nodiscard]] static Result<LuminanceReader> create(const CaptureConfig& config, Arena& arena);

  LuminanceReader(LuminanceReader&&) noexcept;
  LuminanceReader& operator=(LuminanceReader&&) noexcept;
  ~LuminanceReader();

  /// Luminance of the whole image, `info.width_px` x `info.height_px`. The view lives until the image is released and
  /// until the next call. Allocates only to write an error message. Errors: kBadFormat (too few bytes, damaged JPEG).
  [[nodiscard]] Result<GrayView> read(const CapturedImage& image, const CaptureInfo& info);

 private:
  struct Impl;
  explicit LuminanceReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::hal
