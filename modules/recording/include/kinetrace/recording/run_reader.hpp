// Reads a run folder back. For host-side tools; allocates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::recording {

class FolderLock;

/// A finalised camera pose.
struct CameraRow {
  std::int64_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Se3 T_world_cam;
};

/// A row of objects.csv: one object in one finalised frame.
struct ObjectRow {
  std::int64_t frame = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;  ///< Class of the segmentation; see core/detections.hpp.
  BodyStatus status = BodyStatus::kLost;
  Se3 T_world_obj;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< World frame, of the box centre.
  bool moving = false;
  double heading_rad = 0.0;
  Box3 box;
  Box3Sigma box_sigma;                    ///< Zero in runs of earlier versions without it.
  Vector6d variances = Vector6d::Zero();  ///< rad^2 about the world's axes, then m^2 of the origin.
  int point_count = 0;
  int inliers = 0;
  int pixel_height = 0;
  PixelBox mask_px;  ///< Half open; empty without a mask.
};

/// A row of mots.txt: one mask of the left image of its frame.
struct MaskRow {
  std::int64_t frame = 0;
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;
  int width_px = 0;
  int height_px = 0;
  std::string rle;  ///< COCO's compressed run lengths.
};

/// The rows of a run folder. World = first left rectified camera.
struct Run {
  std::filesystem::path directory = {};
  std::string dataset = {};  ///< "LAYOUT:PATH" as given; the path may be relative to the run's working directory.
  /// All fields of the dataset in run.json, by name, including these three.
  std::vector<std::pair<std::string, std::string>> dataset_fields = {};
  std::string sequence = {};                          ///< Name of the sequence.
  std::string cameras = {};                           ///< "gray", "color", or empty.
  std::int64_t passes = 1;                            ///< Number of passes over the recording; frame numbers continue.
  std::string config_json = {};                       ///< The configuration, a JSON object; empty: unknown.
  StereoGeometry rectified = {};                      ///< All zero: unknown.
  RigCorrection applied = {};                         ///< Correction of the right camera at the end.
  bool is_finished = true;                            ///< The run has finished and all files exist.
  std::vector<CameraRow> camera = {};                 ///< By frame.
  std::vector<ObjectRow> objects = {};                ///< By frame, then in the file's order.
  std::optional<std::int64_t> mask_rows = {};         ///< Of mots.txt; none: unknown.
  std::optional<std::int64_t> observation_rows = {};  ///< Of observations.bin; likewise.
  std::vector<std::string> warnings = {};       ///< Given by the run, as in run.json; among them, how it ended early.
  std::vector<std::string> notes = {};          ///< Notes for the user, one line each.
  std::shared_ptr<const FolderLock> lock = {};  ///< Keeps new runs out of the folder while reading.
};

/// Reads run.json, camera.tum, camera_kitti.txt, camera_frames.csv and objects.csv, and checks their consistency. In
/// runs of earlier versions, without camera_frames.csv, frame numbers come from the time stamps of objects.csv, and
/// between and beyond those from the frame interval. Of an aborted or running run it returns the frames common to all
/// files, with a note. Errors, each with file and line: kNotFound (no run folder), kBadFormat (damaged or inconsistent
/// files), kIo.
[[nodiscard]] KINETRACE_API Result<Run> read_run(const std::filesystem::path& directory);

/// Reads mots.txt, ordered by frame; empty if the run wrote none. Errors: kBadFormat with file and line (also: image
/// size or number of rows differ from the run's).
[[nodiscard]] KINETRACE_API Result<std::vector<MaskRow>> read_masks(const Run& run);

}  // namespace kinetrace::recording
