#include "figure/figure_plan.hpp"

#include <algorithm>

namespace kinetrace::figure {
namespace {

double scale_of(const drawing::Rect& area, const drawing::Range& horizontal, const drawing::Range& vertical) {
  return std::min(area.width / horizontal.size(), area.height / vertical.size());
}

drawing::Axes axes_of(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z,
                      bool z_to_the_right) {
  drawing::Axis x_axis{.label = "x right [m]", .range = x};
  drawing::Axis z_axis{.label = "z forward [m]", .range = z};
  if (z_to_the_right) {
    x_axis.reversed = true;
    return {area, z_axis, x_axis};
  }
  return {area, x_axis, z_axis};
}

drawing::Range filling(const drawing::Range& range, double length_px, double pixels_per_metre) {
  return range.at_least(length_px / pixels_per_metre);
}

}  // namespace

PlanView::PlanView(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z, bool z_to_the_right)
    : z_to_the_right_(z_to_the_right),
      z_(z),
      pixels_per_metre_(z_to_the_right ? scale_of(area, z, x) : scale_of(area, x, z)),
      axes_(axes_of(area, filling(x, z_to_the_right ? area.height : area.width, pixels_per_metre_),
                    filling(z, z_to_the_right ? area.width : area.height, pixels_per_metre_), z_to_the_right)) {
  z_ = filling(z, z_to_the_right ? area.width : area.height, pixels_per_metre_);
}

PlanView::PlanView(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z)
    : PlanView(area, x, z, scale_of(area, z, x) > scale_of(area, x, z)) {}

PlanView PlanView::lying(const drawing::Rect& area, const drawing::Range& x, const drawing::Range& z) {
  return {area, x, z, true};
}

drawing::Point PlanView::to_canvas(const Eigen::Vector3d& p) const {
  return z_to_the_right_ ? axes_.to_canvas(p.z(), p.x()) : axes_.to_canvas(p.x(), p.z());
}

Line3 camera_wedge(const Se3& T_world_cam, const StereoGeometry& geometry, double depth_m) {
  const double left = -geometry.cx_px / geometry.fx_px;
  const double right = (geometry.width_px - geometry.cx_px) / geometry.fx_px;
  return {T_world_cam.translation, T_world_cam * Eigen::Vector3d(Eigen::Vector3d(left, 0.0, 1.0) * depth_m),
          T_world_cam * Eigen::Vector3d(Eigen::Vector3d(right, 0.0, 1.0) * depth_m), T_world_cam.translation};
}

}  // namespace kinetrace::figure
