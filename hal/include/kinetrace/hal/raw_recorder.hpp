// Records the raw pairs of a camera to disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

enum class RawFormat : std::uint8_t {
  kKittiRaw,   ///< One PNG per image, in the layout "kitti-raw". For lenses that its calibration file can hold.
  kContainer,  ///< Uncompressed pairs with checksums in a few large files, the layout "container".
};

struct KINETRACE_API RawRecorderConfig {
  std::filesystem::path directory;  ///< Created; an existing one must be empty.
  RawFormat format = RawFormat::kContainer;
  RigCalibration calibration;                                 ///< Stored with the images.
  double rate_hz = 0.0;                                       ///< Nominal.
  std::uint64_t segment_bytes = std::uint64_t{512} << 20U;    ///< Size at which a container begins its next file.
  std::uint64_t keep_free_bytes = std::uint64_t{256} << 20U;  ///< Space to leave free on the disk.

  [[nodiscard]] Status validate() const;
};

/// Appends pairs. After an error (disk full, folder gone) it accepts no more pairs; earlier ones stay readable: an
/// incomplete last record is removed. `write` may block for as long as the disk does: use a thread of its own. `write`
/// allocates for messages only.
class KINETRACE_API RawRecorder {
 public:
  [[nodiscard]] static std::size_t required_bytes(const RawRecorderConfig& config);
  /// What can be known before `create`, without changing anything. Errors: kInvalidConfig, kInvalidArgument (folder not
  /// empty), kUnsupported (calibration that the format cannot hold), kIo.
  [[nodiscard]] static Status check(const RawRecorderConfig& config);
  /// Errors: those of `check`, kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<RawRecorder>> create(const RawRecorderConfig& config, Arena& arena);

  RawRecorder() = default;
  RawRecorder(const RawRecorder&) = delete;
  RawRecorder& operator=(const RawRecorder&) = delete;
  virtual ~RawRecorder() = default;

  /// Frame numbers increase. Errors: kIo (names the file and the reason), kInvalidArgument (size).
  [[nodiscard]] virtual Status write(const StereoFrame& frame) = 0;
  /// Makes all written pairs durable. Errors: kIo.
  [[nodiscard]] virtual Status sync() = 0;
  [[nodiscard]] virtual std::int64_t frames() const noexcept = 0;  ///< Written so far.
};

}  // namespace kinetrace::hal
