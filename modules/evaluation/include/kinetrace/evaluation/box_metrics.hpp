// Errors and consistency of boxes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/evaluation/box_overlap.hpp"
#include "kinetrace/evaluation/error_statistics.hpp"

namespace kinetrace::evaluation {

/// Mean square of errors over their standard deviations; one if the latter are consistent.
class NormalisedErrors {
 public:
  void add(double error, double sigma) noexcept {
    if (sigma > 0.0) {
      ++count_;
      sum_ += error * error / (sigma * sigma);
    }
  }
  [[nodiscard]] std::optional<double> mean_square() const noexcept {
    return count_ > 0 ? std::optional(sum_ / static_cast<double>(count_)) : std::nullopt;
  }

 private:
  std::size_t count_ = 0;
  double sum_ = 0.0;
};

struct BoxErrors {
  ErrorStatistics iou_3d;
  ErrorStatistics iou_footprint;
  ErrorStatistics center_m;
  std::array<ErrorStatistics, 3> size_m;  ///< Length, height, width.
  ErrorStatistics yaw_deg;                ///< Modulo 180 degrees; at most 90.
  std::size_t known_headings = 0;         ///< Boxes whose front the run claims to know ...
  std::size_t known_turned = 0;           ///< ... of these, those with front and rear swapped.
  NormalisedErrors center_normalised;     ///< Along each of the box's axes.
  NormalisedErrors size_normalised;
  NormalisedErrors yaw_normalised;
};

/// Observation state of a box.
enum class BoxStage : std::uint8_t {
  kEarly,   ///< Less than kEarlyFrames frames after its track's first estimate.
  kSeen,    ///< Later, and mostly visible.
  kHidden,  ///< Later; half of the object or more is occluded or outside the image.
};
inline constexpr int kEarlyFrames = 10;
inline constexpr double kHalfHidden = 0.5;
inline constexpr std::array<std::string_view, 3> kBoxStages{"early", "seen", "hidden"};
/// Distance from the camera: below the first limit, the second, beyond.
inline constexpr std::array<double, 2> kBoxDistances_m{20.0, 40.0};
inline constexpr std::array<std::string_view, 3> kBoxDistanceNames{"near", "middle", "far"};

/// By whether the object moves, by distance, by stage.
struct BoxMetrics {
  std::array<std::array<std::array<BoxErrors, kBoxStages.size()>, kBoxDistanceNames.size()>, 2> cells;

  [[nodiscard]] BoxErrors& cell(bool moving, double distance_m, BoxStage stage) noexcept;
};

void compare(const OrientedBox& truth, const Box3& estimate, const Box3Sigma& sigma, BoxErrors& errors);

}  // namespace kinetrace::evaluation
