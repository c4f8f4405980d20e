// Rectifies raw pairs: epipolar lines become rows, both views get the same pinhole camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

struct KINETRACE_API RectifierConfig {
  /// For calibrations without a rectification of their own: 0 zooms until every pixel has image data, 1 keeps every
  /// source pixel, values between interpolate (alpha of cv::stereoRectify, balance of cv::fisheye::stereoRectify).
  double keep_borders = 0.0;

  [[nodiscard]] Status validate() const;
};

/// Rectifies by fixed-point look-up tables (position to 1/32 px, bilinear). Pairs that are rectified already pass
/// through without a copy. Pixels without image data repeat the nearest border pixel, so that no false edges arise.
/// Memory: 12 bytes per rectified pixel for the tables and 2 for the images; none when passing through.
class KINETRACE_API Rectifier {
 public:
  /// Zero if the calibration or the configuration is invalid; `create` then says why.
  [[nodiscard]] static std::size_t required_bytes(const RigCalibration& calibration, const RectifierConfig& config);
  /// Geometry of the rectifier that `create` makes from these. Errors: kBadCalibration, kInvalidConfig.
  [[nodiscard]] static Result<StereoGeometry> rectified_geometry(const RigCalibration& calibration,
                                                                 const RectifierConfig& config);
  /// Errors: kBadCalibration, kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<Rectifier> create(const RigCalibration& calibration, const RectifierConfig& config,
                                                Arena& arena);

  [[nodiscard]] const StereoGeometry& geometry() const noexcept { return geometry_; }
  [[nodiscard]] bool passes_through() const noexcept { return passes_through_; }

  /// The views live until the next call, or as long as the frame's own when passing through. `workers` share the rows;
  /// null: the caller does it alone. Errors: kInvalidArgument (image size differs from the calibration's).
  [[nodiscard]] Result<RectifiedPair> process(const StereoFrame& frame, Workers* workers = nullptr);

 private:
  /// Look-up table and output of one view.
  struct View {
    std::span<std::int16_t> position;   ///< x, y of the upper left source pixel, per target pixel.
    std::span<std::uint16_t> fraction;  ///< Beyond that, in 1/32 px: of x in the lower byte, of y in the upper one.
    MutableGrayView image;
  };

  Rectifier() = default;
  static void carve(const StereoGeometry& geometry, Arena& arena, std::array<View, 2>& views);
  /// Rows [begin, end).
  static void look_up(GrayView source, const View& view, int begin, int end) noexcept;

  StereoGeometry geometry_;
  int raw_width_px_ = 0;
  int raw_height_px_ = 0;
  bool passes_through_ = false;
  std::array<View, 2> views_;
};

/// Applies `correction`, estimated on rectified images (see RigEstimate), to the calibration of the raw images, so that
/// the next start begins with it. Errors: those of Rectifier::create.
[[nodiscard]] KINETRACE_API Result<RigCalibration> corrected_rig(const RigCalibration& calibration,
                                                                 const RectifierConfig& config,
                                                                 const RigCorrection& correction);

}  // namespace kinetrace::hal
