// Ground truth of a simulated recording: poses and masks of objects, and the depth of every pixel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "study/gray16_images.hpp"
#include "study/mots_images.hpp"

namespace kinetrace::app {

/// The true left pictures of one frame.
struct TrueImages {
  evaluation::MotsImage masks;
  ImageView<const std::uint16_t> depth;  ///< Metres * 256, 0 = unknown.

  /// Depth in metres at a point of the left image on the object with this label: interpolated between the four adjacent
  /// pixels as on a plane (inverse depth is linear in the image). None if one of them has another label, or if their
  /// depths differ by more than 2 %: at edges and on surfaces seen at a glancing angle the depth is unknown.
  [[nodiscard]] std::optional<double> depth_at(double x_px, double y_px, std::uint8_t label) const;
};

/// Truth of a folder made by kinetrace-simulate.
class StudyTruth {
 public:
  /// `recording` is the output folder of the simulation. Errors: those of evaluation::read_truth.
  [[nodiscard]] static Result<StudyTruth> open(const std::filesystem::path& recording);

  /// T_world_cam.
  [[nodiscard]] std::optional<Se3> camera_pose(std::int64_t frame) const;
  /// The objects of a study: rigid, moving and visible.
  [[nodiscard]] std::vector<evaluation::LocatedObject> objects(std::int64_t frame) const;
  [[nodiscard]] std::optional<evaluation::LocatedObject> object(std::int64_t frame, std::uint32_t id) const;
  /// The views are valid until the next call. Errors: those of reading images, naming the file.
  [[nodiscard]] Result<TrueImages> images(std::int64_t frame);

 private:
  std::filesystem::path directory_;
  evaluation::Truth truth_;
  MotsImages mots_;
  Gray16Images depths_;
};

}  // namespace kinetrace::app
