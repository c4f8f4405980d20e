// Projections: boxes through the camera, point clouds through an onlooker's view.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "drawing/axes.hpp"
#include "drawing/canvas.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::figure {

using Line2 = std::vector<drawing::Point>;
using Line3 = std::vector<Eigen::Vector3d>;

/// Its twelve edges.
[[nodiscard]] std::vector<Line3> edges_of(const Box3& box);

/// Maps pixels of the rectified image to a canvas.
struct ImagePlace {
  drawing::Rect rect;  ///< Area of the image.
  int width_px = 0;    ///< The image's own size.
  int height_px = 0;

  [[nodiscard]] double scale() const noexcept { return rect.width / width_px; }
  /// Pixel centres of the image lie at integers, those of the canvas at halves.
  [[nodiscard]] drawing::Point to_canvas(double u_px, double v_px) const {
    return {rect.x + (u_px + 0.5) * scale(), rect.y + (v_px + 0.5) * rect.height / height_px};
  }
};

/// Projects lines in the camera frame, clipped at kMinProjectionDepth_m.
[[nodiscard]] std::vector<Line2> project_lines(const std::vector<Line3>& lines_cam, const StereoGeometry& geometry,
                                               const ImagePlace& place);

/// A line seen in `view`, an Onlooker or a PlanView.
template <typename View>
[[nodiscard]] Line2 line_on_canvas(const View& view, const Line3& line) {
  Line2 image;
  for (const Eigen::Vector3d& p : line) {
    image.push_back(view.to_canvas(p));
  }
  return image;
}

/// A distant perspective view, fitted so that most of the subject fills a rectangle.
class Onlooker {
 public:
  struct Direction {
    Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();  ///< Viewing direction before rotation.
    Eigen::Vector3d down = Eigen::Vector3d::UnitY();
    double aside_rad = 0.0;     ///< Then moves around the subject by this angle, to the left,
    double elevated_rad = 0.0;  ///< and rises by this one.
  };
  /// Points to show.
  struct Subject {
    std::span<const Eigen::Vector3d> points;  ///< All but the outermost `outlier_share` on each side of the picture.
    double outlier_share = 0.03;
    std::span<const Eigen::Vector3d> whole;  ///< All but a few per thousand.
  };
  /// Fits the subject into the area; an empty subject is a metre about the origin.
  Onlooker(const Direction& direction, const Subject& subject, const drawing::Rect& area);

  /// Not finite for points behind the onlooker.
  [[nodiscard]] drawing::Point to_canvas(const Eigen::Vector3d& p) const;
  [[nodiscard]] double distance_m(const Eigen::Vector3d& p) const { return (R_view_ * (p - view_)).z(); }
  /// Scale at the middle of the subject.
  [[nodiscard]] double pixels_per_metre() const { return scale_ / middle_distance_m_; }

 private:
  Eigen::Matrix3d R_view_;  ///< Rows: right, down, forward.
  Eigen::Vector3d view_;
  double middle_distance_m_ = 1.0;
  double scale_ = 1.0;
  drawing::Point origin_ = drawing::Point::Zero();
};

/// The pyramid of a camera: its edges, `depth_m` long.
[[nodiscard]] std::vector<Line3> camera_pyramid(const Se3& T_world_cam, const StereoGeometry& geometry, double depth_m);

/// Step n of even thinning to at most `most` of `count` items: the smallest possible, at least 1.
[[nodiscard]] std::size_t every_nth(std::size_t count, std::size_t most);

}  // namespace kinetrace::figure
