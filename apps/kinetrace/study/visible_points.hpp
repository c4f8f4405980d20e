// Visible surface points of moving objects, from ground truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {

/// One object in the frames in which it is visible.
struct SeenBody {
  struct View {
    std::int64_t frame = 0;
    std::int64_t timestamp_ns = 0;
    Se3 T_world_obj;
    Se3 T_cam_obj;
    std::size_t points = 0;  ///< Seen in this frame.
  };
  struct Point {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< In the object.
    std::vector<std::size_t> views;                        ///< Views that show it, ascending.
  };
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< Of its box, in the object.
  std::vector<View> views;                             ///< In ascending time.
  std::vector<Point> points;
};

/// Tracks surface points by true poses and depths. An object has a point in every cell of the image with a depth of its
/// surface; cells have the size of the tracked patches (16 x 11 pixels), so that no two points share pixels. A point
/// ends when it is occluded or leaves the image.
class VisiblePoints {
 public:
  explicit VisiblePoints(const StereoGeometry& geometry) : geometry_(geometry) {}

  /// Takes a frame with its visible moving rigid objects; frames in ascending order.
  void add(std::int64_t frame, std::int64_t timestamp_ns, const Se3& T_world_cam,
           const std::vector<evaluation::LocatedObject>& objects, const TrueImages& images);

  [[nodiscard]] const std::map<std::uint32_t, SeenBody>& bodies() const noexcept { return bodies_; }

 private:
  void add_view(SeenBody& body, const TrueImages& images, std::uint8_t label, const PixelBox& box_px);

  StereoGeometry geometry_;
  std::map<std::uint32_t, SeenBody> bodies_;  ///< By object.
};

}  // namespace kinetrace::app
