// A stereo camera in a simulated world: pictures and exact truth, frame by frame.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "camera/camera_rig.hpp"
#include "camera/rig_errors.hpp"
#include "camera/sensor.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "util/image.hpp"
#include "world/scene.hpp"

namespace kinetrace::simulator {

struct SimulatorSettings {
  std::uint32_t seed = 1;    ///< Of sensor noise, calibration drift and mask degradation.
  int samples_per_side = 2;  ///< A pixel is the mean of its square; 1 to 4.
  int threads = 2;
  bool distortion = false;  ///< Raw pictures of distorted, misaligned lenses.
  double shutter_ms = 0.0;  ///< Above 0: motion blur of this exposure time.
  RigErrors errors;         ///< Errors of the written calibration.
  SensorSettings sensor;

  [[nodiscard]] Status validate() const;
};

/// Truth about one object in one frame. World = left rectified camera of frame 0.
struct ObjectTruth {
  int id = 0;  ///< 1, 2, ... constant over the sequence.
  std::uint16_t class_id = 0;
  bool moving = false;
  bool rigid = true;
  Se3 T_world_obj;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< Of the object's origin, world frame.
  Eigen::Vector3d size_lhw_m = Eigen::Vector3d::Zero();
  int visible_px = 0;                    ///< In the left rectified image.
  PixelBox box_px;                       ///< Of the visible pixels; empty if there are none.
  double occlusion = 0.0;                ///< Fraction of its pixels inside the image that are occluded by others.
  double truncation = 0.0;               ///< Fraction of its projected box outside the image.
  std::array<double, 4> projected_px{};  ///< Left, top, right, bottom of the whole box, clipped to the image.
};

struct SimulatedFrame {
  int index = 0;
  std::int64_t timestamp_ns = 0;
  std::array<Image<std::uint8_t>, 2> pictures;    ///< Raw if the rig is distorted, else rectified.
  std::array<Image<std::uint16_t>, 2> instances;  ///< Rectified; class * 1000 + id, 0 for none (KITTI MOTS).
  std::array<Image<float>, 2> depth_m;            ///< Rectified; 0 for the sky.
  Se3 T_world_cam;
  RigErrors::RightCamera right_camera;
  std::vector<ObjectTruth> objects;  ///< All of the scene, in view or not.
};

class StereoSimulator {
 public:
  /// Errors: kInvalidArgument (settings or scene out of range), kInternal (ray tracer).
  [[nodiscard]] static Result<StereoSimulator> create(Scene scene, const SimulatorSettings& settings);
  StereoSimulator(StereoSimulator&&) noexcept;
  ~StereoSimulator();

  /// Any frame, in any order; the same index gives the same bits.
  [[nodiscard]] SimulatedFrame frame(int index);

  [[nodiscard]] const Scene& scene() const noexcept;
  [[nodiscard]] const CameraRig& rig() const noexcept;
  [[nodiscard]] const SimulatorSettings& settings() const noexcept;

 private:
  struct State;
  explicit StereoSimulator(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kinetrace::simulator
