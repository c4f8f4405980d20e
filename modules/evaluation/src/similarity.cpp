#include "kinetrace/evaluation/similarity.hpp"

#include <algorithm>
#include <map>

#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {
namespace {

using IndexOfId = std::map<std::int64_t, Eigen::Index>;

IndexOfId index_of(std::span<const MaskInstance> instances) {
  IndexOfId indices;
  for (const MaskInstance& instance : instances) {
    indices.emplace(instance.id, static_cast<Eigen::Index>(indices.size()));
  }
  return indices;
}

ImageBox box_of(LabelView labels, std::uint8_t label) {
  PixelBox box;
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      if (labels.at(x, y) == label) {
        box.include(x, y);
      }
    }
  }
  return ImageBox(box);
}

void resize(ObjectFrame& frame) {
  frame.similarity.setZero(static_cast<Eigen::Index>(frame.truth.size()),
                           static_cast<Eigen::Index>(frame.tracks.size()));
}

double shared_px(const MaskOverlap& overlap, Eigen::Index object, Eigen::Index track) {
  const double iou = overlap.iou(object, track);
  return iou * (overlap.truth_area_px(object) + overlap.result_area_px(track)) / (1.0 + iou);
}

}  // namespace

double box_iou(const ImageBox& a, const ImageBox& b) {
  const ImageBox both{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  const double shared = both.area();
  return shared > 0.0 ? shared / (a.area() + b.area() - shared) : 0.0;
}

Status compare_masks(const InstanceMasks& truth, const InstanceMasks& tracks, const std::vector<ImageBox>& track_boxes,
                     ObjectFrame& frame) {
  const Result<MaskOverlap> overlap = overlap_masks(truth, tracks);
  if (!overlap) {
    return Unexpected(overlap.error());
  }
  resize(frame);
  const IndexOfId true_masks = index_of(truth.instances);
  const IndexOfId track_masks = index_of(tracks.instances);
  for (std::size_t i = 0; i < frame.truth.size(); ++i) {
    const auto object = true_masks.find(frame.truth[i].id);
    if (object == true_masks.end()) {
      continue;
    }
    const std::uint8_t label = truth.instances[static_cast<std::size_t>(object->second)].label;
    for (std::size_t j = 0; j < frame.tracks.size(); ++j) {
      double& similarity = frame.similarity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      const auto track = track_masks.find(frame.tracks[j].track_id);
      if (track != track_masks.end()) {
        similarity = overlap->iou(object->second, track->second);
        if (2.0 * shared_px(*overlap, object->second, track->second) > overlap->result_area_px(track->second)) {
          frame.tracks[j].covers = static_cast<int>(i);
        }
      } else if (j < track_boxes.size() && track_boxes[j].area() > 0.0) {
        similarity = box_iou(box_of(truth.labels, label), track_boxes[j]);
      }
    }
  }
  return {};
}

void compare_boxes(const std::vector<ImageBox>& truth_boxes, const std::vector<ImageBox>& track_boxes,
                   ObjectFrame& frame) {
  resize(frame);
  for (std::size_t i = 0; i < truth_boxes.size(); ++i) {
    for (std::size_t j = 0; j < track_boxes.size(); ++j) {
      frame.similarity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          box_iou(truth_boxes[i], track_boxes[j]);
    }
  }
}

void compare_centres(const std::vector<Eigen::Vector3d>& truth_m, const std::vector<Eigen::Vector3d>& tracks_m,
                     double gate_m, ObjectFrame& frame) {
  resize(frame);
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    for (std::size_t j = 0; j < tracks_m.size(); ++j) {
      const double apart_m = (truth_m[i] - tracks_m[j]).norm();
      frame.similarity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          std::isfinite(apart_m) ? std::max(0.0, 1.0 - apart_m / (2.0 * gate_m)) : 0.0;
    }
  }
}

}  // namespace kinetrace::evaluation
