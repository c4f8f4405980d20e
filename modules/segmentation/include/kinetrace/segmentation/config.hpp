// Sources of instance masks, and their settings.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::segmentation {

enum class SegmentationMode : std::uint8_t {
  kAuto,    ///< Motion and a network together; motion alone where there is no network.
  kNone,    ///< No objects: everything is background.
  kMasks,   ///< Mask files beside the recording.
  kMotion,  ///< Independently moving regions, from the residual of the ego motion.
  kDds,     ///< Masks that another process sends, see MaskSource.
  kOnnx,    ///< A neural network in this process, see DelayedMaskSource.
};

inline constexpr std::array<SegmentationMode, 6> kSegmentationModes{SegmentationMode::kAuto, SegmentationMode::kMotion,
                                                                    SegmentationMode::kNone, SegmentationMode::kMasks,
                                                                    SegmentationMode::kOnnx, SegmentationMode::kDds};
/// Default mode.
inline constexpr SegmentationMode kDefaultSegmentation = SegmentationMode::kAuto;

/// True if a neural network in this process is used.
[[nodiscard]] constexpr bool uses_network(SegmentationMode mode) noexcept {
  return mode == SegmentationMode::kAuto || mode == SegmentationMode::kOnnx;
}
/// True if objects are found by their motion.
[[nodiscard]] constexpr bool uses_motion(SegmentationMode mode) noexcept {
  return mode == SegmentationMode::kAuto || mode == SegmentationMode::kMotion;
}

[[nodiscard]] constexpr std::string_view to_string(SegmentationMode mode) noexcept {
  switch (mode) {
    case SegmentationMode::kAuto: return "auto";
    case SegmentationMode::kNone: return "none";
    case SegmentationMode::kMasks: return "masks";
    case SegmentationMode::kMotion: return "motion";
    case SegmentationMode::kDds: return "dds";
    case SegmentationMode::kOnnx: return "onnx";
  }
  return "none";
}

/// Parses a mode; false, with `mode` unchanged, if `text` is none of the names.
[[nodiscard]] constexpr bool from_string(std::string_view text, SegmentationMode& mode) noexcept {
  for (const SegmentationMode candidate : kSegmentationModes) {
    if (text == to_string(candidate)) {
      mode = candidate;
      return true;
    }
  }
  return false;
}

/// Motion segmentation. Defaults suit a car's rig at 10 Hz (f 721 px, baseline .54 m) and hold for 5..30 Hz.
struct KINETRACE_API MotionConfig {
  double sigma_px = 0.4;            ///< Standard deviation of u_left, v and u_right of a feature.
  double ego_sigma_px = 0.2;        ///< Error of the ego motion over the window, seen as image motion.
  double bias_disparity_px = 0.03;  ///< Slowly varying error of the disparity, common to a region.
  double memory_s = 1.0;            ///< Half-life of an observation's weight, [0.05, 10].
  double min_disparity_px = 3.0;    ///< Farther features are ignored.
  double min_speed_mps = 0.1;       ///< Slower regions are not called moving...
  double min_speed_ratio = 0.02;    ///< ... nor those slower than this part of the camera's own speed.
  double significance = 5.0;        ///< Speed over its standard deviation that a moving region must reach.
  int min_features = 5;             ///< Features that agree on a motion, >= 2; fewer suffice if the images agree.
  double link_distance_m = 1.5;     ///< Features farther apart do not join, unless others lie between them.
  int confirm_frames = 2;           ///< Least frames of motion before a region is reported.
  double hold_s = 2.0;              ///< Time for which a reported region is kept after it stops.

  [[nodiscard]] Status validate() const;
};

/// Masks from another process.
struct KINETRACE_API ExternalConfig {
  int timeout_ms = 50;  ///< Longest wait for a frame's masks, [0, 60000]; then tracks are propagated.
  bool right = false;   ///< Request masks of the right image, too; otherwise the tracker derives them.

  [[nodiscard]] Status validate() const;
};

/// Masks from a neural network, which runs in parallel with tracking: masks of frame k are warped to frame k +
/// latency_frames.
struct KINETRACE_API NetworkConfig {
  std::string model;       ///< YAML description of the network; empty: the one that comes with Kinetrace.
  int latency_frames = 1;  ///< Frames after which its masks are used, and the next frame submitted; 0: wait.
  int threads = 1;         ///< Threads of the network, [1, 16].
  bool right = false;  ///< Segment the right image, too, for twice the time; otherwise the tracker derives its masks.
  /// Number of regions around tracks after each whole image, [0, 4], half as wide and high: small objects are enlarged
  /// by two, and those elsewhere are propagated meanwhile. Of the left image only.
  int regions = 0;

  [[nodiscard]] Status validate() const;
};

/// Settings of all modes.
struct KINETRACE_API SegmentationConfig {
  SegmentationMode mode = kDefaultSegmentation;
  std::string left_dir;   ///< Mode kMasks: folder of left masks, `<stem of the left image>.png`.
  std::string right_dir;  ///< Mode kMasks: folder of right masks; empty when there are none.
  int max_objects = 32;  ///< Instances per frame and image, [1, kMaxObjects]; the largest stay, the others are counted.
  int min_area_px = 64;  ///< Smaller instances are dropped and counted.
  MotionConfig motion;
  ExternalConfig dds;
  NetworkConfig onnx;

  [[nodiscard]] Status validate() const;
};

/// Parses `auto[:MODEL.yaml]`, `none`, `motion`, `dds`, `onnx[:MODEL.yaml]` and `masks:LEFT_DIR[,RIGHT_DIR]`; all other
/// settings keep their defaults. Errors: kInvalidArgument.
[[nodiscard]] KINETRACE_API Result<SegmentationConfig> parse_segmentation(std::string_view text);

}  // namespace kinetrace::segmentation
