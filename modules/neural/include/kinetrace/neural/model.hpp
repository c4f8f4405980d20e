// Description of a neural network for instance segmentation: inputs, outputs, classes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::neural {

/// How boxes, classes and masks are read from a network's outputs.
enum class ModelFamily : std::uint8_t {
  kYolov5Seg,     ///< ONNX, exported or with raw heads.
  kYolov8Seg,     ///< ONNX, exported or with raw heads.
  kYolo11Seg,     ///< The same heads as YOLOv8-seg.
  kKinetraceSeg,  ///< ONNX of any input size, as apps/training exports it: a map for each of the strides 8, 16 and 32.
  kMaskRcnn,      ///< TensorFlow frozen graph with the outputs detection_out_final and detection_masks.
};

[[nodiscard]] constexpr std::string_view to_string(ModelFamily family) noexcept {
  switch (family) {
    case ModelFamily::kYolov5Seg: return "yolov5-seg";
    case ModelFamily::kYolov8Seg: return "yolov8-seg";
    case ModelFamily::kYolo11Seg: return "yolo11-seg";
    case ModelFamily::kKinetraceSeg: return "kinetrace-seg";
    case ModelFamily::kMaskRcnn: return "mask-rcnn";
  }
  return "yolov8-seg";
}

enum class InputColours : std::uint8_t { kGray, kRgb, kBgr };
enum class InputFit : std::uint8_t {
  kLetterbox,  ///< Scaled to fit, centred, with a border.
  kStretch,    ///< Scaled in each direction independently.
};

/// The input tensor: [1, channels, height, width], values (grey * scale - mean) / deviation, disparities last.
struct KINETRACE_API ModelInput {
  int width_px = 640;
  int height_px = 640;
  /// Above 0: the size follows the pictures instead, with at most so many pixels. For kKinetraceSeg.
  int max_pixels = 0;
  InputColours colours = InputColours::kRgb;
  /// Adds a channel of the pair's disparities d, matched at half the input's size: log2(1 + d) / 7, d in pixels of the
  /// input; 0 where unknown, and without the other camera's picture. For kKinetraceSeg.
  bool disparity = false;
  InputFit fit = InputFit::kLetterbox;
  float scale = 1.F / 255.F;
  std::array<float, 3> mean{0.F, 0.F, 0.F};  ///< In the order of `colours`.
  std::array<float, 3> deviation{1.F, 1.F, 1.F};
  int pad = 114;  ///< Grey level of the border, before scaling.

  [[nodiscard]] int colour_channels() const noexcept { return colours == InputColours::kGray ? 1 : 3; }
  [[nodiscard]] int channels() const noexcept { return colour_channels() + (disparity ? 1 : 0); }
  /// Input with a given width and height, for pictures of this size: the widest in multiples of 32 that is no wider
  /// than the pictures, holds all of them, and has at most `max_pixels` and 4096 on either side; pictures that are too
  /// long and narrow for that are scaled down into it. Unchanged if `max_pixels` is 0.
  [[nodiscard]] ModelInput sized_for(int picture_width_px, int picture_height_px) const noexcept;
};

/// From scores to probabilities (Platt 1999): the log-odds of an instance are slope * (logit(score) - logit(even)).
/// With the defaults, scores are probabilities.
struct KINETRACE_API ScoreCalibration {
  float slope = 1.F;  ///< Above 0.
  float even = 0.5F;  ///< The score with probability one half, in (0, 1).

  [[nodiscard]] float probability(float score) const noexcept;
  /// Inverse: the score with this probability.
  [[nodiscard]] float score(float probability) const noexcept;
};

/// A class of the network: its class in tracking, threshold and calibration.
struct ModelClass {
  /// Classes whose instances are discarded.
  static constexpr std::uint16_t kDropped = 0xFFFF;

  std::string name;
  std::uint16_t class_id = kDropped;  ///< kVehicleClass, kPedestrianClass, kIgnoreClass, or kDropped.
  float min_score = 0.25F;            ///< Threshold of the network's uncalibrated score, [0, 1].
  ScoreCalibration calibration{};
};

struct ModelThresholds {
  float overlap = 0.5F;  ///< Intersection over union of boxes of one class above which the weaker one is suppressed.
  /// Instances below their class' `min_score` are reported from this probability on, for fusion with other evidence;
  /// not those of ignored classes. 1: none.
  float proposal = 1.F;
};

/// Training data of a network; it misses more in pictures of the other kind.
enum class TrainingPictures : std::uint8_t { kReal, kRendered };

/// A network in a file, and how to use it.
struct KINETRACE_API ModelConfig {
  ModelFamily family = ModelFamily::kYolov8Seg;
  std::string file;   ///< .onnx, or .pb for Mask R-CNN.
  std::string graph;  ///< .pbtxt beside a .pb; may be empty.
  TrainingPictures trained_on = TrainingPictures::kReal;
  ModelInput input;
  std::vector<ModelClass> classes;  ///< In the order of the network's outputs.
  ModelThresholds thresholds;
  /// Raw YOLOv5 heads: width and height in pixels of three anchors per level, strides 8, 16, 32.
  std::array<float, 18> anchors_px{10, 13, 16, 30, 33, 23, 30, 61, 62, 45, 59, 119, 116, 90, 156, 198, 373, 326};

  /// Errors: kInvalidConfig.
  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::neural
