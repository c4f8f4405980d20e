// A simulated stereo rig among static points and moving rigid boxes. It gives the output of a feature tracker (reused
// slots, unique ids, tracks that begin and end, noise, wrong tracks) together with the exact truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::test {

/// A rig like that of the KITTI recordings.
[[nodiscard]] inline StereoGeometry street_rig() {
  return {.fx_px = 721.0,
          .fy_px = 721.0,
          .cx_px = 609.0,
          .cy_px = 173.0,
          .baseline_m = 0.54,
          .width_px = 1242,
          .height_px = 375};
}

struct WorldConfig {
  StereoGeometry geometry = street_rig();
  int capacity = 1200;            ///< Feature slots.
  int background_features = 600;  ///< Alive at any time.
  double nearest_m = 5.0;         ///< Background points begin between these depths, log-uniform.
  double farthest_m = 60.0;
  double sigma_px = 0.3;           ///< Standard deviation of u_left, v and u_right.
  double noise_persistence = 0.0;  ///< Part of a track's error that persists from frame to frame, [0, 1).
  int min_track_frames = 5;        ///< Tracks last between these, uniform, unless the point leaves the image.
  int max_track_frames = 25;
  double right_ratio = 0.9;        ///< Part of the observations that have a right match.
  double wrong_track_ratio = 0.0;  ///< Part of the tracks that slide over the image at 2..8 px a frame.
  double wrong_right_ratio = 0.0;  ///< Part of the right matches at random positions.
  double frame_interval_s = 0.1;
  std::uint32_t seed = 1;
};

/// Truth of a feature.
struct TrueFeature {
  std::uint8_t body = 0;
  bool wrong = false;  ///< A wrong track.
  Eigen::Vector3d p_body = Eigen::Vector3d::Zero();
};

/// A box with features on the sides that face the camera. Its frame is at the centre: x length, y height, z width.
struct SyntheticObject {
  Eigen::Vector3d size_m{4.0, 1.5, 1.8};
  int features = 60;
};

class SyntheticWorld {
 public:
  explicit SyntheticWorld(const WorldConfig& config, std::vector<SyntheticObject> objects = {})
      : config_(config),
        objects_(std::move(objects)),
        random_(config.seed),
        tracks_(static_cast<std::size_t>(config.capacity)) {}

  /// The next frame, objects at `T_world_obj` (one per object). Label of object k is k + 1; the world is body 0.
  FeatureFrame observe(const Se3& T_world_cam, std::span<const Se3> T_world_obj = {}) {
    T_body_cam_.assign(1, T_world_cam);
    for (const Se3& T : T_world_obj) {
      T_body_cam_.push_back(T.inverse() * T_world_cam);
    }
    for (Track& track : tracks_) {
      if (track.alive) {
        advance(track);
      }
    }
    for (std::size_t body = 0; body < T_body_cam_.size(); ++body) {
      fill_up(static_cast<std::uint8_t>(body));
    }
    frame_.clear();
    for (const Track& track : tracks_) {
      if (track.alive) {
        frame_.push_back(track.feature);
      }
    }
    const std::int64_t index = next_index_++;
    return {.frame_index = index, .timestamp_ns = timestamp_ns(index), .features = frame_};
  }

  /// A frame in which nothing is seen: every track ends.
  FeatureFrame observe_nothing() {
    for (Track& track : tracks_) {
      track.alive = false;
    }
    frame_.clear();
    const std::int64_t index = next_index_++;
    return {.frame_index = index, .timestamp_ns = timestamp_ns(index), .features = frame_};
  }

  [[nodiscard]] const TrueFeature& truth(const Feature& feature) const { return tracks_[feature.slot].truth; }
  /// Position in its body's frame of the point that feature `id` tracked; ids begin at 1.
  [[nodiscard]] const Eigen::Vector3d& point_of(std::uint32_t id) const { return point_of_id_.at(id - 1); }
  [[nodiscard]] bool wrong(std::uint32_t id) const { return wrong_id_.at(id - 1); }

 private:
  struct Track {
    bool alive = false;
    Feature feature;
    TrueFeature truth;
    int frames_left = 0;
    Eigen::Vector2f slide_px{0.F, 0.F};  ///< Of a wrong track, a frame.
    Eigen::Vector2f slid_px{0.F, 0.F};
    Eigen::Vector3f noise_px{0.F, 0.F, 0.F};
  };

  [[nodiscard]] std::int64_t timestamp_ns(std::int64_t index) const {
    return 1'000'000'000 +
           static_cast<std::int64_t>(std::llround(static_cast<double>(index) * config_.frame_interval_s * 1e9));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool chance(double ratio) { return ratio > 0.0 && uniform(0.0, 1.0) < ratio; }
  Eigen::Vector3f fresh_noise() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).cast<float>() *
           static_cast<float>(config_.sigma_px);
  }

  Eigen::Vector3f next_noise(Track& track) {
    const auto keep = static_cast<float>(config_.noise_persistence);
    const bool first = track.noise_px.isZero();
    const Eigen::Vector3f fresh = fresh_noise();
    track.noise_px = first ? fresh : Eigen::Vector3f(keep * track.noise_px + std::sqrt(1.F - keep * keep) * fresh);
    return track.noise_px;
  }

  /// Measures the track's point in this frame; false when it cannot be seen.
  bool measure(Track& track) {
    const Eigen::Vector3d p_cam = T_body_cam_[track.truth.body].inverse() * track.truth.p_body;
    if (p_cam.z() < 2.0) {
      return false;
    }
    const Eigen::Vector3d uvr = config_.geometry.project(p_cam);
    Feature& f = track.feature;
    const Eigen::Vector3f seen = uvr.cast<float>() + next_noise(track);  // u_left, v, u_right
    f.left_px = seen.head<2>() + track.slid_px;
    f.v_px = f.left_px.y();
    f.u_right_px = seen.z() + track.slid_px.x();
    if (!chance(config_.right_ratio) || f.u_right_px < 0.F) {
      f.u_right_px = kNoRight;
    } else if (chance(config_.wrong_right_ratio)) {
      f.u_right_px = f.left_px.x() - static_cast<float>(uniform(1.0, 100.0));
    }
    return f.left_px.x() >= 0.F && f.left_px.y() >= 0.F &&
           f.left_px.x() < static_cast<float>(config_.geometry.width_px) &&
           f.left_px.y() < static_cast<float>(config_.geometry.height_px);
  }

  void advance(Track& track) {
    Feature& f = track.feature;
    f.previous_left_px = f.left_px;
    f.previous_v_px = f.v_px;
    f.previous_u_right_px = f.u_right_px;
    ++f.age_frames;
    track.slid_px += track.slide_px;
    track.alive = track.truth.body < T_body_cam_.size() && --track.frames_left > 0 && measure(track);
  }

  void fill_up(std::uint8_t body) {
    const int wanted = body == 0 ? config_.background_features : objects_[body - 1U].features;
    auto alive = std::count_if(tracks_.begin(), tracks_.end(),
                               [body](const Track& t) { return t.alive && t.truth.body == body; });
    for (int attempt = 0; alive < wanted && attempt < 20 * wanted; ++attempt) {
      const auto free = std::find_if(tracks_.begin(), tracks_.end(), [](const Track& t) { return !t.alive; });
      if (free == tracks_.end()) {
        return;
      }
      alive += start(*free, body) ? 1 : 0;
    }
  }

  bool start(Track& track, std::uint8_t body) {
    track = Track{};
    track.truth.body = body;
    track.truth.p_body = body == 0 ? background_point() : object_point(body);
    track.truth.wrong = chance(config_.wrong_track_ratio);
    if (!measure(track)) {
      return false;
    }
    // The first frames begin with tracks of every age, as in the middle of a run.
    const int shortest = next_index_ == 0 ? 1 : config_.min_track_frames;
    track.frames_left = std::uniform_int_distribution<int>(shortest, config_.max_track_frames)(random_);
    if (track.truth.wrong) {
      const double direction = uniform(0.0, 6.28);
      const double speed_px = uniform(2.0, 8.0);
      track.slide_px = Eigen::Vector2d(speed_px * std::cos(direction), speed_px * std::sin(direction)).cast<float>();
    }
    Feature& f = track.feature;
    f.id = static_cast<std::uint32_t>(point_of_id_.size() + 1);
    f.slot = static_cast<std::uint16_t>(&track - tracks_.data());
    f.body = body;
    f.intensity = static_cast<std::uint8_t>(f.id % 256U);
    f.previous_left_px = f.left_px;
    f.previous_v_px = f.v_px;
    f.previous_u_right_px = f.u_right_px;
    point_of_id_.push_back(track.truth.p_body);
    wrong_id_.push_back(track.truth.wrong);
    track.alive = true;
    return true;
  }

  Eigen::Vector3d background_point() {
    const StereoGeometry& g = config_.geometry;
    const double z = config_.nearest_m * std::pow(config_.farthest_m / config_.nearest_m, uniform(0.0, 1.0));
    const double u = uniform(0.0, g.width_px);
    const double v = uniform(0.0, g.height_px);
    return T_body_cam_[0] * g.triangulate(u, v, g.disparity_px(z));
  }

  /// A point on a side of the box that the camera can see.
  Eigen::Vector3d object_point(std::uint8_t body) {
    const Eigen::Vector3d half = 0.5 * objects_[body - 1U].size_m;
    const Eigen::Vector3d& camera = T_body_cam_[body].translation;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int attempt = 0; attempt < 100; ++attempt) {
      p = {uniform(-half.x(), half.x()), uniform(-half.y(), half.y()), uniform(-half.z(), half.z())};
      const auto axis = std::uniform_int_distribution<Eigen::Index>(0, 2)(random_);
      const double side = chance(0.5) ? 1.0 : -1.0;
      p[axis] = side * half[axis];
      if (side * (camera[axis] - p[axis]) > 0.0) {
        break;
      }
    }
    return p;
  }

  WorldConfig config_;
  std::vector<SyntheticObject> objects_;
  std::mt19937 random_;
  std::vector<Track> tracks_;
  std::vector<Feature> frame_;
  std::vector<Se3> T_body_cam_;
  std::vector<Eigen::Vector3d> point_of_id_;
  std::vector<bool> wrong_id_;
  std::int64_t next_index_ = 0;
};

/// `angle_rad` about the vertical (y) axis.
[[nodiscard]] inline Se3 turned(double angle_rad, const Eigen::Vector3d& translation_m = Eigen::Vector3d::Zero()) {
  return {so3_exp({0.0, angle_rad, 0.0}), translation_m};
}

/// Pose of a vehicle after `distance_m` along a circle of `curvature` (1/m, 0 = straight ahead along z).
[[nodiscard]] inline Se3 driven(double distance_m, double curvature = 0.0) {
  if (std::abs(curvature) < 1e-12) {
    return turned(0.0, {0.0, 0.0, distance_m});
  }
  const double angle = distance_m * curvature;
  return turned(angle, {(1.0 - std::cos(angle)) / curvature, 0.0, std::sin(angle) / curvature});
}

[[nodiscard]] inline double rotation_error_deg(const Se3& a, const Se3& b) {
  return so3_log(a.rotation.transpose() * b.rotation).norm() * 57.29577951308232;
}

}  // namespace kinetrace::test
