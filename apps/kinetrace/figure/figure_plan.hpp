// Views along an axis, to scale, in metres.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "drawing/axes.hpp"
#include "drawing/canvas.hpp"
#include "figure/figure_views.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::figure {

/// The x-z plane seen from above: against y, which points down. z points up, or right where that gives a larger scale;
/// x is always on the right-hand side of z, never mirrored.
class PlanView {
 public:
  /// `area` excludes the margins of the axes.
  PlanView(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z);
  /// Always with z to the right.
  [[nodiscard]] static PlanView lying(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z);

  void draw_axes(drawing::Canvas& canvas) const { axes_.draw(canvas); }
  [[nodiscard]] const drawing::Rect& area() const noexcept { return axes_.area(); }
  [[nodiscard]] drawing::Point to_canvas(const Eigen::Vector3d& p) const;
  [[nodiscard]] double pixels_per_metre() const noexcept { return pixels_per_metre_; }
  /// Range of z, extended to fill the area.
  [[nodiscard]] const drawing::Range& z_range() const noexcept { return z_; }

 private:
  PlanView(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z, bool z_to_the_right);

  bool z_to_the_right_;
  drawing::Range z_;
  double pixels_per_metre_;
  drawing::Axes axes_;
};

/// A camera from above: the triangle of its field of view, `depth_m` deep.
[[nodiscard]] Line3 camera_wedge(const Se3& T_world_cam, const StereoGeometry& geometry, double depth_m);

}  // namespace kinetrace::figure
