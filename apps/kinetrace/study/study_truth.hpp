// What a simulated recording knows about its objects: poses, masks and the depth of every pixel.
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

  /// Depth in metres at a place of the left image on the object with this label: between the four pixels around it, as
  /// a plane has it (inverse depth is linear in the image). None where one of them shows something else, or where their
  /// depths differ by more than 2 %: on edges and on surfaces seen at a glancing angle the depth at a pixel is not
  /// known.
  [[nodiscard]] std::optional<double> depth_at(double x_px, double y_px, std::uint8_t label) const;
};

/// Truth of a folder made by kinetrace-simulate.
class StudyTruth {
 public:
  /// `recording` is the folder that was simulated into. Errors: those of evaluation::read_truth.
  [[nodiscard]] static Result<StudyTruth> open(const std::filesystem::path& recording);

  /// T_world_cam.
  [[nodiscard]] std::optional<Se3> camera_pose(std::int64_t frame) const;
  /// Rigid objects that move and can be seen; these are studied.
  [[nodiscard]] std::vector<evaluation::LocatedObject> objects(std::int64_t frame) const;
  [[nodiscard]] std::optional<evaluation::LocatedObject> object(std::int64_t frame, std::uint32_t id) const;
  /// The views live until the next call. Errors: those of reading images, naming the file.
  [[nodiscard]] Result<TrueImages> images(std::int64_t frame);

 private:
  std::filesystem::path directory_;
  evaluation::Truth truth_;
  MotsImages mots_;
  Gray16Images depths_;
};

}  // namespace kinetrace::app
