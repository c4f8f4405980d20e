#include "rendering/stereo_simulator.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <string>
#include <utility>

#include "rendering/image_renderer.hpp"
#include "rendering/object_truth.hpp"
#include "rendering/ray_world.hpp"
#include "rendering/truth_renderer.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

constexpr std::array<View, 2> kViews{View::kLeft, View::kRight};
// The epoch of the recordings: 2026-01-01 00:00:00 UTC.
constexpr std::int64_t kStart_ns = 1'767'225'600'000'000'000;

Status check_range(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) {
    return {};
  }
  return fail(ErrorCode::kInvalidArgument, std::string(name) + " must be in [" + std::to_string(low) + ", " +
                                               std::to_string(high) + "], got " + std::to_string(value));
}

}  // namespace

Status SimulatorSettings::validate() const {
  struct Range {
    const char* name;
    double value;
    double low;
    double high;
  };
  const std::array<Range, 7> ranges{{{"samples per side", static_cast<double>(samples_per_side), 1, 4},
                                     {"threads", static_cast<double>(threads), 1, 256},
                                     {"shutter", shutter_ms, 0, 1000},
                                     {"noise", sensor.noise_levels, 0, 50},
                                     {"vignetting", sensor.vignetting, 0, 0.9},
                                     {"blur", sensor.blur_px, 0, 2},
                                     {"gain", sensor.right_gain, 0.25, 4}}};
  for (const Range& range : ranges) {
    if (Status status = check_range(range.name, range.value, range.low, range.high); !status) {
      return status;
    }
  }
  return errors.validate();
}

struct StereoSimulator::State {
  State(Scene simulated, const SimulatorSettings& chosen)
      : scene(std::move(simulated)),
        settings(chosen),
        rig(chosen.distortion ? distorted_rig(scene.rig) : ideal_rig(scene.rig)),
        rays{SampleRays(rig.raw[0], chosen.samples_per_side), SampleRays(rig.raw[1], chosen.samples_per_side)},
        world(scene),
        T_world_scene(scene.T_scene_cam(0.0).inverse()) {}

  [[nodiscard]] Se3 T_scene_view(View view, double time_s) const {
    Se3 pose = scene.T_scene_cam(time_s);
    if (view == View::kRight) {
      pose.translation += pose.rotation.col(0) * scene.rig.baseline_m;
    }
    return pose;
  }

  [[nodiscard]] ViewPose true_pose(View view, double time_s) const {
    ViewPose pose{T_scene_view(view, time_s)};
    if (view == View::kRight && settings.errors.move_right_camera()) {
      const RigErrors::RightCamera right = settings.errors.right_camera(time_s, settings.seed);
      const Eigen::Matrix3d R_scene_cam = pose.T_scene_view.rotation;
      const Eigen::Vector3d direction(1.0, std::tan(right.baseline_rad.x()), std::tan(right.baseline_rad.y()));
      pose.T_scene_view.translation +=
          R_scene_cam * (scene.rig.baseline_m * (direction.normalized() - Eigen::Vector3d::UnitX()));
      pose.T_scene_view.rotation = R_scene_cam * so3_exp(right.turn_rad);
      pose.principal_shift = right.principal_shift.cast<float>();
    }
    return pose;
  }

  // Approximate length, on the sensor, of the motion during the exposure.
  [[nodiscard]] double streak_px(double time_s) const {
    constexpr double kSurroundings_m = 4.0;
    constexpr double kNearest_m = 2.0;
    const double half_s = 0.5e-3 * settings.shutter_ms;
    const Se3 opened = scene.T_scene_cam(time_s - half_s);
    const Se3 closed = scene.T_scene_cam(time_s + half_s);
    const double turned_rad = so3_log(opened.rotation.transpose() * closed.rotation).norm();
    double streak_rad = turned_rad + (closed.translation - opened.translation).norm() / kSurroundings_m;
    for (const Actor& actor : scene.actors) {
      const Eigen::Vector3d before = actor.T_scene_obj(time_s - half_s).translation;
      const Eigen::Vector3d after = actor.T_scene_obj(time_s + half_s).translation;
      const double distance_m = std::max((after - closed.translation).norm(), kNearest_m);
      streak_rad = std::max(streak_rad, turned_rad + (after - before).norm() / distance_m);
    }
    return scene.rig.fx_px * streak_rad;
  }

  // Enough instants that motion blur shows streaks instead of separate copies.
  [[nodiscard]] int instants_at(double time_s) const {
    constexpr double kMin = 4.0;
    constexpr double kMax = 24.0;
    return settings.shutter_ms > 0.0 ? static_cast<int>(std::clamp(std::ceil(streak_px(time_s)), kMin, kMax)) : 1;
  }

  // With an open shutter, the mean of several instants about `time_s`.
  [[nodiscard]] std::array<Image<float>, 2> collect_light(double time_s, std::array<TruthImages, 2>* truth) {
    const int instants = instants_at(time_s);
    std::array<Image<float>, 2> light{Image<float>(rays[0].width(), rays[0].height()),
                                      Image<float>(rays[1].width(), rays[1].height())};
    for (int i = 0; i < instants; ++i) {
      const double instant_s = time_s + 1e-3 * settings.shutter_ms * ((i + 0.5) / instants - 0.5);
      world.set_time(instant_s);
      for (const View view : kViews) {
        const auto side = static_cast<std::size_t>(view);
        add_radiance(world, rays[side], true_pose(view, instant_s), settings.threads,
                     1.F / static_cast<float>(instants), light[side], truth != nullptr ? &(*truth)[side] : nullptr);
      }
    }
    return light;
  }

  // Whether the picture is an instantaneous view by the calibrated cameras, so that its rays also give the truth.
  [[nodiscard]] bool picture_shows_truth() const {
    return !rig.distorted && settings.shutter_ms == 0.0 && !settings.errors.move_right_camera();
  }

  void find_truth(double time_s, std::array<TruthImages, 2>& truth) {
    world.set_time(time_s);
    for (const View view : kViews) {
      truth[static_cast<std::size_t>(view)] =
          render_truth(world, scene.rig, T_scene_view(view, time_s), settings.threads);
    }
  }

  Scene scene;
  SimulatorSettings settings;
  CameraRig rig;
  std::array<SampleRays, 2> rays;
  RayWorld world;
  Se3 T_world_scene;
};

Result<StereoSimulator> StereoSimulator::create(Scene scene, const SimulatorSettings& settings) {
  if (const Status status = settings.validate(); !status) {
    return Unexpected(status.error());
  }
  if (scene.actors.size() > static_cast<std::size_t>(kMaxObjects)) {
    return fail(ErrorCode::kInvalidArgument, "scene " + scene.name + " has more than 64 objects");
  }
  try {
    return StereoSimulator(std::make_unique<State>(std::move(scene), settings));
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInternal, error.what());
  }
}

StereoSimulator::StereoSimulator(std::unique_ptr<State> state) : state_(std::move(state)) {}
StereoSimulator::StereoSimulator(StereoSimulator&&) noexcept = default;
StereoSimulator::~StereoSimulator() = default;

SimulatedFrame StereoSimulator::frame(int index) {
  State& s = *state_;
  const double time_s = index / s.scene.rate_hz;
  SimulatedFrame frame;
  frame.index = index;
  frame.timestamp_ns = kStart_ns + std::llround(1e9 * time_s);
  frame.T_world_cam = s.T_world_scene * s.T_scene_view(View::kLeft, time_s);
  frame.right_camera = s.settings.errors.right_camera(time_s, s.settings.seed);
  const TruthImages empty(s.scene.rig.width_px, s.scene.rig.height_px);
  std::array<TruthImages, 2> truth{empty, empty};
  std::array<Image<float>, 2> light = s.collect_light(time_s, s.picture_shows_truth() ? &truth : nullptr);
  if (!s.picture_shows_truth()) {
    s.find_truth(time_s, truth);
  }
  frame.objects =
      observe_objects(s.world, s.scene.rig, truth[0], time_s, s.T_scene_view(View::kLeft, time_s), s.T_world_scene);
  for (const View view : kViews) {
    const auto side = static_cast<std::size_t>(view);
    const double gain = view == View::kRight ? s.settings.sensor.right_gain : 1.0;
    frame.pictures[side] = expose(std::move(light[side]), s.settings.sensor, gain * s.scene.light.exposure,
                                  hash_of(s.settings.seed, index, side), s.settings.threads);
    frame.instances[side] = mots_labels(truth[side].actors, s.scene.actors);
    frame.depth_m[side] = std::move(truth[side].depth_m);
  }
  return frame;
}

const Scene& StereoSimulator::scene() const noexcept {
  return state_->scene;
}
const CameraRig& StereoSimulator::rig() const noexcept {
  return state_->rig;
}
const SimulatorSettings& StereoSimulator::settings() const noexcept {
  return state_->settings;
}

}  // namespace kinetrace::simulator
