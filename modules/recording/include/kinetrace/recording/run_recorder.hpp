// Writes the run folder: trajectories, labels, masks, point clouds and COLMAP models, from FrameResult alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/run_summary.hpp"

namespace kinetrace::recording {

struct KINETRACE_API RecordingConfig {
  std::filesystem::path directory;  ///< Made if it does not exist; must be empty or an earlier run folder.
  StereoGeometry geometry;          ///< Of the rectified pair; becomes the COLMAP camera.
  bool mots = true;                 ///< Write mots.txt.
  bool points = true;               ///< Write points/.
  bool observations = true;         ///< Write observations.bin, for refinement after the run.
  bool colmap = true;               ///< Write colmap/.
  bool images = false;              ///< Write images/: the rectified left images, which the COLMAP models are of.
  bool is_rectified = false;        ///< The recorded images are, so that the COLMAP models are of these, too.
  bool repeats = false;             ///< The recording is played more than once: a name is no longer that of one frame.
  int max_objects = kMaxObjects;    ///< Objects in one frame, in [1, 64].
  int flush_interval_frames = 1;    ///< A run that is killed loses at most so many frames of its text files.
  int conversion_kib = 1024;        ///< Working memory of `finish`, in [64, 262144]; more memory, fewer passes.
  std::int64_t max_trajectory_vertices = 2'000'000;  ///< Per points/object_ID.ply; beyond it frames are thinned evenly.

  [[nodiscard]] Status validate() const;
};

/// Call `record` for every result of the pipeline in order, those of drain() included, then `finish` once.
///
/// `record` appends to files opened in `create`: it never allocates, but for `images`, and holds at most twelve files
/// open. What has to be regrouped by object or point goes to spool files in DIR/.spool, which `finish` turns into
/// tracks/, points/ and colmap/ within `conversion_kib` of memory, however long the run was. See README.md for every
/// file and column.
class KINETRACE_API RunRecorder {
 public:
  /// Prepares the folder and opens its files. Files of an earlier run there are removed, others are left alone. The
  /// folder is locked until the recorder goes, or the process ends in whatever way.
  /// Errors: kInvalidConfig (which key), kInvalidArgument (folder is neither empty nor a run folder, or another run or
  /// a reader uses it), kIo (cannot be written), kCapacity (arena too small).
  [[nodiscard]] static Result<RunRecorder> create(const RecordingConfig& config, Arena& arena);
  /// Bytes that `create` takes from the arena. `config` must be valid.
  [[nodiscard]] static std::size_t required_bytes(const RecordingConfig& config);

  RunRecorder(RunRecorder&&) noexcept;
  RunRecorder& operator=(RunRecorder&&) noexcept;
  ~RunRecorder();  ///< Without `finish` the folder stays as it is, with its spool and without run.json; see read_run.

  /// Leaves what is known of the run before its first frame to readers of a run that never finishes. Errors: as
  /// `finish`.
  [[nodiscard]] Status begin(const RunSummary& summary);

  /// Appends one result. Errors: kIo (disk full...), kInvalidArgument (frame numbers do not increase or exceed 31 bits,
  /// a pose is not finite), kCapacity (more than max_objects objects), kIllegalState (after finish). After an error the
  /// recorder takes nothing more: each further call returns the first error.
  [[nodiscard]] Status record(const FrameResult& result);

  /// Closes the files, converts the spool and writes run.json last: a folder with run.json is complete.
  /// Errors: kIo, kInvalidArgument (summary.config_json is no JSON object), kIllegalState (called twice), or the error
  /// that stopped `record`.
  [[nodiscard]] Status finish(const RunSummary& summary);

 private:
  struct Impl;
  explicit RunRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording
