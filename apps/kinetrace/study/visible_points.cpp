#include "study/visible_points.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace kinetrace::app {
namespace {

constexpr int kCellWidth_px = 16;
constexpr int kCellHeight_px = 11;
// Relative tolerance between a point's depth and the true depth at its pixel: about the error of the surface between
// pixels.
constexpr double kSameDepth = 0.02;
constexpr std::int64_t kMotsIdsPerClass = 1000;

using Cell = std::pair<int, int>;

Cell cell_of(double x_px, double y_px) {
  return {static_cast<int>(std::floor(x_px / kCellWidth_px)), static_cast<int>(std::floor(y_px / kCellHeight_px))};
}

/// Bounding boxes by label.
std::map<std::uint8_t, PixelBox> boxes_of(LabelView labels) {
  std::map<std::uint8_t, PixelBox> boxes;
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      const std::uint8_t label = labels.at(x, y);
      if (label == kBackgroundLabel) {
        continue;
      }
      PixelBox& box = boxes.try_emplace(label, PixelBox{x, y, x + 1, y + 1}).first->second;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), std::max(box.y1, y + 1)};
    }
  }
  return boxes;
}

}  // namespace

void VisiblePoints::add(std::int64_t frame, std::int64_t timestamp_ns, const Se3& T_world_cam,
                        const std::vector<evaluation::LocatedObject>& objects, const TrueImages& images) {
  const std::map<std::uint8_t, PixelBox> boxes = boxes_of(images.masks.masks().labels);
  for (const evaluation::LocatedObject& object : objects) {
    for (const evaluation::MaskInstance& instance : images.masks.instances) {
      const auto box = boxes.find(instance.label);
      if (instance.id % kMotsIdsPerClass != object.object.id || box == boxes.end()) {
        continue;
      }
      SeenBody& body = bodies_[object.object.id];
      const Se3& T_world_obj = object.object.T_world_obj;
      body.center_m = T_world_obj.inverse() * object.center_m;
      body.views.push_back({frame, timestamp_ns, T_world_obj, T_world_cam.inverse() * T_world_obj, 0});
      add_view(body, images, instance.label, box->second);
    }
  }
}

void VisiblePoints::add_view(SeenBody& body, const TrueImages& images, std::uint8_t label, const PixelBox& box_px) {
  const std::size_t index = body.views.size() - 1;
  SeenBody::View& view = body.views.back();
  std::set<Cell> taken;
  for (SeenBody::Point& point : body.points) {
    if (point.views.back() + 1 != index) {
      continue;
    }
    const Eigen::Vector3d p_cam = view.T_cam_obj * point.position_m;
    const Eigen::Vector3d seen = geometry_.project(p_cam);
    const std::optional<double> depth_m = images.depth_at(seen.x(), seen.y(), label);
    if (depth_m && std::abs(*depth_m - p_cam.z()) < kSameDepth * p_cam.z() &&
        taken.insert(cell_of(seen.x(), seen.y())).second) {
      point.views.push_back(index);
      ++view.points;
    }
  }
  const Cell last = cell_of(box_px.x1 - 1, box_px.y1 - 1);
  const Cell first = cell_of(box_px.x0, box_px.y0);
  for (int row = first.second; row <= last.second; ++row) {
    for (int column = first.first; column <= last.first; ++column) {
      const double x_px = (column + 0.5) * kCellWidth_px;
      const double y_px = (row + 0.5) * kCellHeight_px;
      const std::optional<double> depth_m = images.depth_at(x_px, y_px, label);
      if (depth_m && taken.insert({column, row}).second) {
        const Eigen::Vector3d p_cam = geometry_.triangulate(x_px, y_px, geometry_.disparity_px(*depth_m));
        body.points.push_back({view.T_cam_obj.inverse() * p_cam, {index}});
        ++view.points;
      }
    }
  }
}

}  // namespace kinetrace::app
