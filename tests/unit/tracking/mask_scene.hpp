// Exact synthetic masks and features: rectangles and ellipses that move, grow and occlude each other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {

inline constexpr int kWidth = 640;
inline constexpr int kHeight = 240;

/// An upright rectangle or ellipse in the left image; the right one sees it shifted by the disparity.
struct Shape {
  double x = 0.0;  ///< Centre.
  double y = 0.0;
  double half_width = 30.0;
  double half_height = 20.0;
  double disparity_px = 10.0;
  bool ellipse = false;
  std::uint16_t class_id = kVehicleClass;

  [[nodiscard]] bool covers(double px, double py) const {
    const double u = (px - x) / half_width;
    const double v = (py - y) / half_height;
    return ellipse ? u * u + v * v <= 1.0 : std::abs(u) <= 1.0 && std::abs(v) <= 1.0;
  }
};

inline Shape shifted(Shape shape, double dx, double dy = 0.0) {
  shape.x += dx;
  shape.y += dy;
  return shape;
}

[[nodiscard]] inline ImageExtent extent_of(const Shape& shape, double sigma_px) {
  const Eigen::Vector2d centre_px(shape.x + 0.5, shape.y + 0.5);
  const Eigen::Vector2d half_px(shape.half_width + 0.5, shape.half_height + 0.5);
  return {.low_px = centre_px - half_px,
          .high_px = centre_px + half_px,
          .low_sigma_px = Eigen::Vector2d::Constant(sigma_px),
          .high_sigma_px = Eigen::Vector2d::Constant(sigma_px)};
}

/// A label image with storage.
class Labels {
 public:
  Labels() : pixels_(static_cast<std::size_t>(kWidth) * kHeight) {}
  [[nodiscard]] LabelView view() const { return {pixels_.data(), kWidth, kHeight, kWidth}; }
  [[nodiscard]] MutableLabelView view() { return {pixels_.data(), kWidth, kHeight, kWidth}; }
  void clear() { std::fill(pixels_.begin(), pixels_.end(), kBackgroundLabel); }
  void draw(const Shape& shape, std::uint8_t label, double shift_px = 0.0) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (shape.covers(x + shift_px, y)) {
          view().at(x, y) = label;
        }
      }
    }
  }

 private:
  std::vector<std::uint8_t> pixels_;
};

[[nodiscard]] inline int area_of(LabelView labels, std::uint8_t label) {
  int area = 0;
  for (int y = 0; y < labels.height; ++y) {
    area += static_cast<int>(std::count(labels.row(y), labels.row(y) + labels.width, label));
  }
  return area;
}

[[nodiscard]] inline double mask_iou(LabelView a, std::uint8_t label_a, LabelView b, std::uint8_t label_b) {
  int both = 0;
  int either = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const bool in_a = a.at(x, y) == label_a;
      const bool in_b = b.at(x, y) == label_b;
      both += in_a && in_b ? 1 : 0;
      either += in_a || in_b ? 1 : 0;
    }
  }
  return either == 0 ? 0.0 : static_cast<double>(both) / either;
}

[[nodiscard]] inline std::vector<Detection> measure_detections(LabelView labels, std::span<const std::uint8_t> wanted,
                                                               std::span<const std::uint16_t> classes) {
  std::vector<Detection> out;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    Detection d{wanted[i], classes[i], 1.F, {}, 0};
    for (int y = 0; y < labels.height; ++y) {
      for (int x = 0; x < labels.width; ++x) {
        if (labels.at(x, y) == wanted[i]) {
          d.box_px.include(x, y);
          ++d.area_px;
        }
      }
    }
    if (d.area_px > 0) {
      out.push_back(d);
    }
  }
  return out;
}

/// Drives a tracker with shapes. Shapes occlude each other by disparity; each shape has features at fixed places.
class TrackerScene {
 public:
  explicit TrackerScene(const TrackerConfig& config = {}, int features_per_shape = 24)
      : features_per_shape_(features_per_shape),
        arena_(StereoTracker::required_bytes(config, kWidth, kHeight)),
        tracker_(StereoTracker::create(config, kWidth, kHeight, arena_).value()) {}

  /// Properties of the next frame's detections.
  bool available = true;
  PixelBox searched_px;
  bool moving_only = false;
  bool moving = false;  ///< Of each detection.
  bool with_right = false;
  std::vector<bool> detected;             ///< Per shape, default all.
  std::vector<std::uint8_t> label_order;  ///< Label of each shape, default 1, 2, ...
  double feature_noise_px = 0.0;
  std::vector<ObjectPrediction> object_predictions;  ///< By slot.
  std::int64_t interval_ns = kUsualInterval_ns;

  /// Truth label of shape k is k + 1.
  const TrackFrame& step(std::span<const Shape> shapes) {
    draw(shapes);
    std::vector<Feature> features = place_features(shapes);
    frame_ = tracker_.process(next_timestamp_ns(), detections_, features, object_predictions).value();
    previous_.assign(shapes.begin(), shapes.end());
    has_previous_ = true;
    return frame_;
  }

  [[nodiscard]] std::int64_t next_timestamp_ns() { return timestamp_ns_ += interval_ns; }
  [[nodiscard]] StereoTracker& tracker() { return tracker_; }
  [[nodiscard]] const DetectionFrame& detections() const { return detections_; }
  [[nodiscard]] const TrackFrame& frame() const { return frame_; }
  [[nodiscard]] LabelView truth_left() const { return truth_left_.view(); }
  [[nodiscard]] LabelView truth_right() const { return truth_right_.view(); }
  [[nodiscard]] Labels& left_labels() { return left_; }

  /// The track that shows most pixels of shape k, nullptr if there is none.
  [[nodiscard]] const Track* track_of(std::size_t k) const {
    const Track* best = nullptr;
    double best_iou = 0.0;
    for (const Track& track : frame_.tracks) {
      const double iou = mask_iou(frame_.left_labels, track.label(), truth_left_.view(), truth_label(k));
      if (iou > best_iou) {
        best_iou = iou;
        best = &track;
      }
    }
    return best;
  }
  [[nodiscard]] double left_iou(const Track& track, std::size_t k) const {
    return mask_iou(frame_.left_labels, track.label(), truth_left_.view(), truth_label(k));
  }
  [[nodiscard]] double right_iou(const Track& track, std::size_t k) const {
    return mask_iou(frame_.right_labels, track.label(), truth_right_.view(), truth_label(k));
  }

 private:
  [[nodiscard]] static std::uint8_t truth_label(std::size_t k) { return static_cast<std::uint8_t>(k + 1); }
  [[nodiscard]] bool is_detected(std::size_t k) const { return k >= detected.size() || detected[k]; }
  [[nodiscard]] std::uint8_t detection_label(std::size_t k) const {
    return k < label_order.size() ? label_order[k] : truth_label(k);
  }

  void draw(std::span<const Shape> shapes) {
    std::vector<std::size_t> far_to_near(shapes.size());
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      far_to_near[k] = k;
    }
    std::stable_sort(far_to_near.begin(), far_to_near.end(),
                     [&](std::size_t a, std::size_t b) { return shapes[a].disparity_px < shapes[b].disparity_px; });
    for (Labels* labels : {&left_, &right_, &truth_left_, &truth_right_}) {
      labels->clear();
    }
    for (const std::size_t k : far_to_near) {
      const std::uint8_t shown = is_detected(k) ? detection_label(k) : kBackgroundLabel;
      left_.draw(shapes[k], shown);
      right_.draw(shapes[k], shown, shapes[k].disparity_px);
      truth_left_.draw(shapes[k], truth_label(k));
      truth_right_.draw(shapes[k], truth_label(k), shapes[k].disparity_px);
    }
    std::vector<std::uint8_t> wanted;
    std::vector<std::uint16_t> classes;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      if (is_detected(k)) {
        wanted.push_back(detection_label(k));
        classes.push_back(shapes[k].class_id);
      }
    }
    left_detections_ = measure_detections(left_.view(), wanted, classes);
    right_detections_ = measure_detections(right_.view(), wanted, classes);
    for (Detection& detection : left_detections_) {
      detection.moving = moving;
    }
    detections_ = {};
    detections_.available = available;
    detections_.searched_px = searched_px;
    detections_.moving_only = moving_only;
    if (available) {
      detections_.left_labels = std::as_const(left_).view();
      detections_.left = left_detections_;
      if (with_right) {
        detections_.right_labels = std::as_const(right_).view();
        detections_.right = right_detections_;
      }
    }
  }

  double noise() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return feature_noise_px * 2.0 * (static_cast<double>(state_ >> 40U) / (1U << 24U) - 0.5);
  }

  /// Features lie on a sunflower pattern inside each shape, wherever the shape is visible in both frames.
  std::vector<Feature> place_features(std::span<const Shape> shapes) {
    std::vector<Feature> features;
    for (std::size_t k = 0; has_previous_ && k < std::min(shapes.size(), previous_.size()); ++k) {
      for (int i = 0; i < features_per_shape_; ++i) {
        const double radius = 0.85 * std::sqrt((i + 0.5) / features_per_shape_);
        const double u = radius * std::cos(2.4 * i);
        const double v = radius * std::sin(2.4 * i);
        const auto place = [&](const Shape& s) {
          return Eigen::Vector2d(s.x + u * s.half_width, s.y + v * s.half_height);
        };
        const Eigen::Vector2d now = place(shapes[k]) + Eigen::Vector2d(noise(), noise());
        const Eigen::Vector2d before = place(previous_[k]);
        Feature f;
        f.id = static_cast<std::uint32_t>(k * 1000 + static_cast<std::size_t>(i) + 1);
        f.slot = static_cast<std::uint16_t>(features.size());
        f.age_frames = 1;
        f.left_px = now.cast<float>();
        f.previous_left_px = before.cast<float>();
        f.v_px = f.left_px.y();
        f.u_right_px = f.left_px.x() - static_cast<float>(shapes[k].disparity_px);
        if (label_at(truth_left_.view(), now) != truth_label(k)) {
          continue;  // hidden, or outside
        }
        f.body = label_at(frame_.left_labels, before);
        features.push_back(f);
      }
    }
    return features;
  }

  [[nodiscard]] static std::uint8_t label_at(LabelView labels, const Eigen::Vector2d& p) {
    const int x = static_cast<int>(std::lround(p.x()));
    const int y = static_cast<int>(std::lround(p.y()));
    return labels.contains(x, y) ? labels.at(x, y) : kBackgroundLabel;
  }

  int features_per_shape_ = 0;
  Arena arena_;
  StereoTracker tracker_;
  Labels left_;
  Labels right_;
  Labels truth_left_;
  Labels truth_right_;
  std::vector<Detection> left_detections_;
  std::vector<Detection> right_detections_;
  DetectionFrame detections_;
  TrackFrame frame_;
  std::vector<Shape> previous_;
  bool has_previous_ = false;
  std::uint64_t state_ = 42;
  std::int64_t timestamp_ns_ = 0;
};

}  // namespace kinetrace::tracking
