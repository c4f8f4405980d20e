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
  std::filesystem::path directory;  ///< Created if missing; must be empty or an earlier run folder.
  StereoGeometry geometry;          ///< Of the rectified pair; becomes the COLMAP camera.
  bool mots = true;                 ///< Write mots.txt.
  bool points = true;               ///< Write points/.
  bool observations = true;         ///< Write observations.bin, for refinement after the run.
  bool colmap = true;               ///< Write colmap/.
  bool images = false;              ///< Write images/: the rectified left images of the COLMAP models.
  bool is_rectified = false;        ///< The recorded images are rectified; COLMAP models then refer to them.
  bool repeats = false;             ///< The recording is played more than once: names are not unique.
  int max_objects = kMaxObjects;    ///< Objects in one frame, in [1, 64].
  int flush_interval_frames = 1;    ///< A killed run loses at most this number of frames of its text files.
  int conversion_kib = 1024;        ///< Working memory of `finish`, in [64, 262144]; more memory, fewer passes.
  std::int64_t max_trajectory_vertices = 2'000'000;  ///< Per points/object_ID.ply; beyond it frames are thinned evenly.

  [[nodiscard]] Status validate() const;
};

/// Call `record` for every result of the pipeline in order, those of drain() included, then `finish` once.
///
/// `record` appends to files opened in `create`: it never allocates, but for `images`, and holds at most twelve files
/// open. Data to regroup by object or point goes to spool files in DIR/.spool, which `finish` converts to tracks/,
/// points/ and colmap/ within `conversion_kib` of memory, independent of the run's length. See README.md for every file
/// and column.
class KINETRACE_API RunRecorder {
 public:
  /// Prepares the folder and opens its files. Files of an earlier run are removed, others are kept. The folder is
  /// locked until the recorder is destroyed or the process ends. Errors: kInvalidConfig (which key), kInvalidArgument
  /// (folder is neither empty nor a run folder, or another run or a reader uses it), kIo (cannot be written), kCapacity
  /// (arena too small).
  [[nodiscard]] static Result<RunRecorder> create(const RecordingConfig& config, Arena& arena);
  /// Whether `create` can use the folder, for runs written at the end of long work. Leaves it as it is; where it is
  /// missing, one is made and removed again. Errors: as `create`.
  [[nodiscard]] static Status check_folder(const std::filesystem::path& directory);
  /// Bytes that `create` takes from the arena. `config` must be valid.
  [[nodiscard]] static std::size_t required_bytes(const RecordingConfig& config);

  RunRecorder(RunRecorder&&) noexcept;
  RunRecorder& operator=(RunRecorder&&) noexcept;
  ~RunRecorder();  ///< Without `finish` the folder keeps its spool and has no run.json; see read_run.

  /// Writes the run's description, for readers of an unfinished run. Call before the first frame. Errors: as `finish`.
  [[nodiscard]] Status begin(const RunSummary& summary);

  /// Appends one result. Errors: kIo (disk full...), kInvalidArgument (frame numbers do not increase or exceed 31 bits,
  /// a pose is not finite), kCapacity (more than max_objects objects), kIllegalState (after finish). After an error
  /// each further call returns the first error.
  [[nodiscard]] Status record(const FrameResult& result);

  /// Closes the files, converts the spool and writes run.json last: run.json marks a complete folder. Errors: kIo,
  /// kInvalidArgument (summary.config_json is no JSON object), kIllegalState (called twice), or the error that stopped
  /// `record`.
  [[nodiscard]] Status finish(const RunSummary& summary);

 private:
  struct Impl;
  explicit RunRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording
