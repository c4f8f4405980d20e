// Ground truth from files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/evaluation/object_metrics.hpp"
#include "kinetrace/evaluation/similarity.hpp"

namespace kinetrace::evaluation {

enum class TruthFormat : std::uint8_t {
  kSimulator,      ///< Folder with camera_poses.txt and objects.csv, as kinetrace-simulate writes it.
  kKittiTracking,  ///< Object labels `frame id type ...`; needs camera poses beside it.
  kKittiPoses,     ///< 12 numbers a line: T_world_cam of frame 0, 1, 2, ...
  kTum,            ///< `time tx ty tz qx qy qz qw` of the left camera.
  kEuroc,          ///< `time,px,py,pz,qw,qx,qy,qz,...` of the body; needs T_body_cam.
};
inline constexpr std::array<std::pair<std::string_view, TruthFormat>, 5> kTruthFormats{
    {{"simulator", TruthFormat::kSimulator},
     {"kitti-tracking", TruthFormat::kKittiTracking},
     {"kitti-poses", TruthFormat::kKittiPoses},
     {"tum", TruthFormat::kTum},
     {"euroc", TruthFormat::kEuroc}}};
[[nodiscard]] std::string_view to_string(TruthFormat format) noexcept;

/// The true camera, by frame number or by time.
struct TrueCamera {
  struct Pose {
    std::int64_t key = 0;  ///< Frame number, or time in ns.
    Se3 T_world_cam;
  };
  bool by_time = false;
  std::vector<Pose> poses;  ///< By key.

  /// The pose of a frame. By time: interpolated between the two neighbours if both are within `tolerance_ns`, else the
  /// nearer one if it is within it; none otherwise.
  [[nodiscard]] std::optional<Se3> at(std::int64_t frame, std::int64_t timestamp_ns, std::int64_t tolerance_ns) const;
};

/// An object with its position for association.
struct LocatedObject {
  TrueObject object;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< Of its box, world frame.
  ImageBox box_px;                                     ///< Empty if the truth has none.
};

struct Truth {
  TruthFormat format = TruthFormat::kSimulator;
  TrueCamera camera;
  std::map<std::int64_t, std::vector<LocatedObject>> objects;  ///< By frame; visible objects.
  bool has_objects = false;
  bool has_boxes = false;
  bool is_complete = false;           ///< Contains all objects.
  std::filesystem::path mask_folder;  ///< KITTI MOTS images named by frame number, %010d.png or %06d.png; empty: none.
};

struct TruthSource {
  std::filesystem::path path;         ///< File or folder.
  std::optional<TruthFormat> format;  ///< None: detected.
  std::filesystem::path camera;       ///< For kKittiTracking: a file of another format with the camera's poses.
  std::optional<Se3> T_body_cam;      ///< For kEuroc: T_BS of the left camera's sensor.yaml.
  std::filesystem::path masks;        ///< Instead of the truth's own masks.
  std::map<std::int64_t, std::int64_t> frame_times_ns;  ///< Of the run, for formats that have only frame numbers.
  std::int64_t time_tolerance_ns = 10'000'000;
};

/// Reads ground truth. Errors, with file and line: kNotFound, kBadFormat, kInvalidArgument (a file required by the
/// format is missing), kUnsupported (no format is recognised).
[[nodiscard]] Result<Truth> read_truth(const TruthSource& source);

/// The truth's mask image of a frame, or none if it has no such file.
[[nodiscard]] std::optional<std::filesystem::path> mask_path(const Truth& truth, std::int64_t frame);

}  // namespace kinetrace::evaluation
