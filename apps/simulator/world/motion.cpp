#include "world/motion.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

constexpr int kSamplesPerSpan = 64;

Se3 ground_pose(const Eigen::Vector2d& at, double heading_rad) {
  return {Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitY()).toRotationMatrix(), {at.x(), 0.0, at.y()}};
}

}  // namespace

GroundPath::GroundPath(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {
  // Mirrored end points make the curve begin and end exactly at the first and the last point.
  points_.insert(points_.begin(), 2.0 * points_[0] - points_[1]);
  points_.push_back(2.0 * points_.back() - points_[points_.size() - 2]);
  const std::size_t spans = points_.size() - 3;
  arc_lengths_.push_back(0.0);
  samples_.push_back(point_at(0.0));
  for (std::size_t i = 1; i <= spans * kSamplesPerSpan; ++i) {
    samples_.push_back(point_at(static_cast<double>(i) / kSamplesPerSpan));
    arc_lengths_.push_back(arc_lengths_.back() + (samples_[i] - samples_[i - 1]).norm());
  }
}

Eigen::Vector2d GroundPath::point_at(double parameter) const {
  const auto spans = static_cast<double>(points_.size() - 3);
  const double clamped = std::clamp(parameter, 0.0, spans);
  const auto span = static_cast<std::size_t>(std::min(std::floor(clamped), spans - 1.0));
  const double t = clamped - static_cast<double>(span);
  const double t2 = t * t;
  const double t3 = t2 * t;
  return ((1.0 - 3.0 * t + 3.0 * t2 - t3) * points_[span] + (4.0 - 6.0 * t2 + 3.0 * t3) * points_[span + 1] +
          (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) * points_[span + 2] + t3 * points_[span + 3]) /
         6.0;
}

Se3 GroundPath::pose_at(double distance_m) const {
  const auto after = std::upper_bound(arc_lengths_.begin() + 1, arc_lengths_.end() - 1, distance_m);
  const auto i = static_cast<std::size_t>(after - arc_lengths_.begin());
  const double t = (distance_m - arc_lengths_[i - 1]) / (arc_lengths_[i] - arc_lengths_[i - 1]);
  const Eigen::Vector2d position = samples_[i - 1] + t * (samples_[i] - samples_[i - 1]);
  // Chord directions change in steps; between the chords' middles the tangent is interpolated.
  const auto chord = [&](std::size_t k) -> Eigen::Vector2d {
    const std::size_t last = samples_.size() - 1;
    const std::size_t end = std::clamp<std::size_t>(k, 1, last);
    return (samples_[end] - samples_[end - 1]).normalized();
  };
  const double s = std::clamp(t, 0.0, 1.0);
  const Eigen::Vector2d tangent = s < 0.5 ? Eigen::Vector2d((0.5 - s) * chord(i - 1) + (0.5 + s) * chord(i))
                                          : Eigen::Vector2d((1.5 - s) * chord(i) + (s - 0.5) * chord(i + 1));
  return ground_pose(position, std::atan2(-tangent.y(), tangent.x()));
}

SpeedProfile::SpeedProfile(std::vector<Knot> knots) : knots_(std::move(knots)) {}

double SpeedProfile::distance_since(const Knot& from, const Knot& to, double time_s) const {
  const double span = to.time_s - from.time_s;
  const double s = std::clamp((time_s - from.time_s) / span, 0.0, 1.0);
  // Integral of a cubic step from one speed to the other.
  return span * (from.speed_mps * s + (to.speed_mps - from.speed_mps) * (s * s * s - 0.5 * s * s * s * s));
}

double SpeedProfile::distance_m(double time_s) const {
  const auto from_start = [&](double until_s) {
    double distance = std::min(until_s - knots_.front().time_s, 0.0) * knots_.front().speed_mps;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      distance += distance_since(knots_[i], knots_[i + 1], until_s);
    }
    return distance + std::max(until_s - knots_.back().time_s, 0.0) * knots_.back().speed_mps;
  };
  return from_start(time_s) - from_start(0.0);
}

SpeedProfile SpeedProfile::scaled(double factor) const {
  SpeedProfile result = *this;
  for (Knot& knot : result.knots_) {
    knot.speed_mps *= factor;
  }
  return result;
}

Trajectory drive(GroundPath path, SpeedProfile speed, double start_m) {
  auto shared_path = std::make_shared<const GroundPath>(std::move(path));
  return [shared_path, speed = std::move(speed), start_m](double time_s) {
    return shared_path->pose_at(start_m + speed.distance_m(time_s));
  };
}

Trajectory parked(double x_m, double z_m, double heading_rad) {
  return [pose = ground_pose({x_m, z_m}, heading_rad)](double /*time_s*/) { return pose; };
}

Trajectory raised(Trajectory trajectory, double height_m) {
  return [trajectory = std::move(trajectory), height_m](double time_s) {
    Se3 pose = trajectory(time_s);
    pose.translation.y() -= height_m;
    return pose;
  };
}

Se3 sway_at(const Sway& sway, double time_s) {
  constexpr int kSines = 4;
  Vector6d amplitude;
  amplitude << sway.rotation_rad, sway.translation_m;
  Vector6d offset = Vector6d::Zero();
  for (int axis = 0; axis < 6; ++axis) {
    Random random(sway.seed, axis, 77);
    for (int i = 0; i < kSines; ++i) {
      const double frequency_hz =
          sway.slowest_hz * std::pow(sway.fastest_hz / sway.slowest_hz, (i + random.unit()) / kSines);
      const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
      // Faster sines are smaller, because of the carrier's inertia.
      const double weight = 0.6 * std::sqrt(sway.slowest_hz / frequency_hz);
      offset[axis] += amplitude[axis] * weight * std::sin(2.0 * std::numbers::pi * frequency_hz * time_s + phase);
    }
  }
  return {so3_exp(offset.head<3>()), offset.tail<3>()};
}

Trajectory mounted(Trajectory carrier, double height_m, double pitch_rad, const Sway& sway) {
  // Camera axes (x right, y down, z forward) in a body's (x forward, y down, z left).
  Se3 T_body_cam;
  T_body_cam.rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  T_body_cam.rotation = T_body_cam.rotation * Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitX());
  T_body_cam.translation = {0.0, -height_m, 0.0};
  return [carrier = std::move(carrier), T_body_cam, sway](double time_s) {
    return carrier(time_s) * T_body_cam * sway_at(sway, time_s);
  };
}

}  // namespace kinetrace::simulator
