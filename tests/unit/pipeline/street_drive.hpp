// Short drives through the rendered street, and their exact truth.
#pragma once

#include <filesystem>
#include <vector>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "rendered_world.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {

/// A vehicle that keeps its velocity.
struct Mover {
  Eigen::Vector3d size_m{2.4, 2.2, 3.0};
  Eigen::Vector3d start_m{1.5, 0.4, 9.0};
  Eigen::Vector3d velocity_mps{0.3, 0.0, 5.5};
};

/// The camera drives ahead at 5 m/s, turning slowly, ten frames a second.
class StreetDrive {
 public:
  static constexpr double kFrame_s = 0.1;

  explicit StreetDrive(std::vector<Mover> movers = {}, const StereoGeometry& geometry = small_rig())
      : world_(geometry), movers_(std::move(movers)) {}

  [[nodiscard]] static Se3 T_world_cam(int frame);
  [[nodiscard]] Se3 T_world_mover(std::size_t mover, int frame) const;
  /// Mover k carries label k + 1.
  [[nodiscard]] RenderedPair render(int frame) const;
  [[nodiscard]] const StereoGeometry& geometry() const noexcept { return world_.geometry(); }
  [[nodiscard]] const std::vector<Mover>& movers() const noexcept { return movers_; }

 private:
  RenderedWorld world_;
  std::vector<Mover> movers_;
};

/// Name of a frame's image and mask files, without folder and extension.
[[nodiscard]] std::string stem_of(int frame);

/// Writes the masks of both views as KITTI MOTS files into `folder`/left and `folder`/right.
void write_masks(const RenderedPair& pair, int frame, const std::filesystem::path& folder,
                 std::uint16_t class_id = kVehicleClass);

/// Mask files in a folder of their own.
class MaskFolder {
 public:
  void write(const RenderedPair& pair, int frame, std::uint16_t class_id = kVehicleClass) {
    write_masks(pair, frame, folder_.path(), class_id);
  }
  [[nodiscard]] std::filesystem::path left() const { return folder_.path() / "left"; }
  [[nodiscard]] std::filesystem::path right() const { return folder_.path() / "right"; }

 private:
  TempFolder folder_;
};

/// Defaults, with features as dense as small images need.
[[nodiscard]] pipeline::PipelineConfig small_config();
[[nodiscard]] pipeline::PipelineConfig small_config(const MaskFolder& masks);
[[nodiscard]] pipeline::PipelineConfig small_config(segmentation::SegmentationMode mode);

}  // namespace kinetrace::test
