// Synthetic bundle windows with exact truth.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "kinetrace/core/bundle.hpp"

namespace kinetrace::refinement {

struct SceneOptions {
  int frames = 10;
  int points = 500;
  int track_frames = 5;  ///< Length of each point's run of observations.
  double noise_px = 0.3;
  double outlier_ratio = 0.0;        ///< Observations displaced by tens of pixels.
  double mono_ratio = 0.0;           ///< Observations without a right match.
  double turn_sigma_rad = 0.0;       ///< 0: no prior on the body's rotation.
  double unexpected_turn_rad = 0.0;  ///< Per frame, about each axis; not part of the prior.
  double min_depth_m = 4.0;
  double max_depth_m = 40.0;
  double pose_error_m = 0.05;  ///< Error of the initial free poses; a tenth of it in rad.
  double point_error = 0.03;   ///< Error of the initial points, relative to their depth.
  double baseline_m = 0.54;
  Se3 T_body_start;  ///< Pose of the first camera.
  std::uint32_t fixed_frames = 1U;
  std::uint32_t seed = 1;
};

/// A window with its storage and its truth. The camera drives forward and turns a little.
struct BundleScene {
  StereoGeometry geometry{721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375};
  std::vector<Se3> true_T_body_cam;
  std::vector<Eigen::Vector3d> true_points_m;
  std::vector<Se3> T_body_cam;
  std::vector<BundlePoint> points;
  std::vector<BundleObservation> observations;
  std::vector<TurnPrior> turns;
  std::uint32_t fixed_frames = 1U;

  [[nodiscard]] BundleWindow window() { return {geometry, T_body_cam, fixed_frames, points, observations, turns}; }
  [[nodiscard]] BundleObservation& observation(std::size_t point, std::size_t frame) {
    return observations[point * T_body_cam.size() + frame];
  }
};

/// Priors that lack the body's turn of `options.unexpected_turn_rad` a frame.
inline std::vector<TurnPrior> expected_turns(const SceneOptions& options, const std::vector<Se3>& T_body_cam) {
  std::vector<TurnPrior> turns(options.turn_sigma_rad > 0.0 ? T_body_cam.size() : 0);
  const Eigen::Matrix3d unexpected = so3_exp(Eigen::Vector3d::Constant(options.unexpected_turn_rad));
  for (std::size_t k = 1; k < turns.size(); ++k) {
    turns[k] = {T_body_cam[k - 1].rotation.transpose() * T_body_cam[k].rotation * unexpected,
                1.0 / options.turn_sigma_rad};
  }
  return turns;
}

inline BundleScene make_scene(const SceneOptions& options) {
  std::mt19937 random(options.seed);
  std::normal_distribution<double> gauss(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  BundleScene scene;
  scene.geometry.baseline_m = options.baseline_m;
  scene.fixed_frames = options.fixed_frames;
  for (int k = 0; k < options.frames; ++k) {
    const Se3 T_start_cam{so3_exp({0.005 * k, 0.02 * k, -0.003 * k}), {0.05 * k, 0.01 * k, 0.4 * k}};
    const Se3 T_body_cam = options.T_body_start * T_start_cam;
    scene.true_T_body_cam.push_back(T_body_cam);
    const bool fixed = (options.fixed_frames >> k & 1U) != 0;
    Vector6d error;
    for (int i = 0; i < 6; ++i) {
      error[i] = gauss(random) * options.pose_error_m * (i < 3 ? 0.1 : 1.0);
    }
    // The error is applied at the camera, whatever the body frame.
    scene.T_body_cam.push_back(fixed ? T_body_cam : T_body_cam * left_update(Se3{}, error));
  }
  scene.observations.resize(static_cast<std::size_t>(options.points * options.frames));
  const int latest_start = std::max(options.frames - options.track_frames, 0);
  for (int p = 0; p < options.points; ++p) {
    const int first = static_cast<int>(uniform(random) * (latest_start + 1)) % (latest_start + 1);
    const int last = std::min(first + options.track_frames, options.frames);
    const Se3& T_body_first = scene.true_T_body_cam[static_cast<std::size_t>(first)];
    const double z = options.min_depth_m + uniform(random) * (options.max_depth_m - options.min_depth_m);
    const Eigen::Vector3d p_cam((uniform(random) - 0.5) * 1.4 * z, (uniform(random) - 0.5) * 0.5 * z, z);
    const Eigen::Vector3d p_body = T_body_first * p_cam;
    scene.true_points_m.push_back(p_body);
    BundlePoint point;
    const double stretch = 1.0 + options.point_error * gauss(random);
    point.position_m = T_body_first * Eigen::Vector3d(p_cam * stretch);
    for (int k = first; k < last; ++k) {
      const Eigen::Vector3d seen =
          scene.geometry.project(scene.true_T_body_cam[static_cast<std::size_t>(k)].inverse() * p_body);
      BundleObservation observation;
      const double outlier = uniform(random) < options.outlier_ratio ? 30.0 : 0.0;
      const auto noisy = [&](double value) {
        return static_cast<float>(value + options.noise_px * gauss(random) + outlier * gauss(random));
      };
      observation.u_left_px = noisy(seen[0]);
      observation.v_px = noisy(seen[1]);
      observation.u_right_px = noisy(seen[2]);
      if (uniform(random) < options.mono_ratio) {
        observation.u_right_px = kNoRight;
      }
      observation.inverse_sigma_px = static_cast<float>(1.0 / std::max(options.noise_px, 0.01));
      scene.observations[static_cast<std::size_t>(p * options.frames + k)] = observation;
      point.frames |= 1U << k;
    }
    scene.points.push_back(point);
  }
  scene.turns = expected_turns(options, scene.true_T_body_cam);
  return scene;
}

/// Position and rotation distance of two poses, seen from the camera.
struct PoseDifference {
  double position_m = 0.0;
  double angle_rad = 0.0;
};
inline PoseDifference difference(const Se3& a, const Se3& b) {
  return {(a.translation - b.translation).norm(), so3_log(a.rotation.transpose() * b.rotation).norm()};
}
inline PoseDifference largest_difference(const std::vector<Se3>& a, const std::vector<Se3>& b) {
  PoseDifference largest;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const PoseDifference d = difference(a[k], b[k]);
    largest.position_m = std::max(largest.position_m, d.position_m);
    largest.angle_rad = std::max(largest.angle_rad, d.angle_rad);
  }
  return largest;
}

}  // namespace kinetrace::refinement
