#include "run_folder.hpp"

#include <algorithm>
#include <array>
#include <system_error>

#include "buffered_file.hpp"
#include "kinetrace/core/files.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMarker = "Kinetrace run folder";  // First line of README.txt.

enum class Part { kAlways, kMots, kObservations, kPoints, kColmap, kImages };

struct KnownFile {
  std::string_view path;  ///< "ID" stands for a track id, "NAME" for an image's name.
  Part part;
  std::string_view content;
  std::uint64_t RunCounts::*count = nullptr;  ///< Number of files; null: one.
  std::uint64_t RunCounts::*rows = nullptr;   ///< Number of rows, if counted.
};

constexpr std::array<KnownFile, 20> kKnownFiles{{
    {"README.txt", Part::kAlways, "this overview"},
    {"run.json", Part::kAlways, "version, configuration, timings, memory, counters, warnings; written last"},
    {"camera.tum", Part::kAlways, "camera in the world per frame: timestamp tx ty tz qx qy qz qw"},
    {"camera_kitti.txt", Part::kAlways, "the same as KITTI poses: 12 numbers, row-major 3 x 4"},
    {kCameraFramesFile, Part::kAlways, "their frame numbers and timestamps"},
    {"objects.csv", Part::kAlways, "every object in every frame: pose, velocity, box, covariance, counts", nullptr,
     &RunCounts::object_rows},
    {"label_02.txt", Part::kAlways, "the same as KITTI tracking labels, camera frame", nullptr, &RunCounts::label_rows},
    {"mots.txt", Part::kMots, "tracked left masks in KITTI MOTS format", nullptr, &RunCounts::mask_rows},
    {"observations.bin", Part::kObservations, "image positions of points, for refinement after the run", nullptr,
     &RunCounts::observations},
    {"tracks/ID.tum", Part::kAlways, "object ID in the world per frame, as camera.tum", &RunCounts::tracks},
    {"images/NAME.png", Part::kImages, "rectified left images, named as in the COLMAP models", &RunCounts::images},
    {"points/background.ply", Part::kPoints, "background points, world frame"},
    {"points/object_ID.ply", Part::kPoints, "points of object ID at every frame, world frame",
     &RunCounts::object_clouds},
    {"points/object_ID_model.ply", Part::kPoints, "points of object ID, object frame", &RunCounts::object_clouds},
    {"colmap/background/cameras.txt", Part::kColmap, "COLMAP text model of the background"},
    {"colmap/background/images.txt", Part::kColmap, "its images"},
    {"colmap/background/points3D.txt", Part::kColmap, "its points"},
    {"colmap/object_ID/cameras.txt", Part::kColmap, "COLMAP text model of object ID", &RunCounts::object_models},
    {"colmap/object_ID/images.txt", Part::kColmap, "its images", &RunCounts::object_models},
    {"colmap/object_ID/points3D.txt", Part::kColmap, "its points", &RunCounts::object_models},
}};
/// Made from a run by other commands; removed, since those of an earlier run would be mistaken for the new run's.
constexpr std::array<std::string_view, 9> kDerivedFiles{"evaluation.json",
                                                        "figure.png",
                                                        "map",
                                                        "map/map.json",
                                                        "map/map.png",
                                                        "map/trajectories.csv",
                                                        "map/trajectories.geojson",
                                                        "map/trajectories.gpx",
                                                        "map/trajectories.kml"};
constexpr std::array<std::string_view, 6> kKnownFolders{
    "tracks", "images", "points", "colmap", "colmap/background", "colmap/object_ID"};

bool enabled(Part part, const RecordingConfig& config) {
  switch (part) {
    case Part::kAlways: return true;
    case Part::kMots: return config.mots;
    case Part::kObservations: return config.observations;
    case Part::kPoints: return config.points;
    case Part::kColmap: return config.colmap;
    case Part::kImages: return config.images;
  }
  return false;
}

/// `path` equals `pattern` with digits in the place of "ID", or any name in that of "NAME".
bool matches(std::string_view path, std::string_view pattern) {
  for (const std::string_view place : {std::string_view("ID"), std::string_view("NAME")}) {
    const std::size_t begin = pattern.find(place);
    if (begin == std::string_view::npos) {
      continue;
    }
    const std::string_view before = pattern.substr(0, begin);
    const std::string_view after = pattern.substr(begin + place.size());
    if (path.size() <= before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after)) {
      return false;
    }
    const std::string_view name = path.substr(before.size(), path.size() - before.size() - after.size());
    return std::all_of(name.begin(), name.end(),
                       [&](char c) { return place == "ID" ? c >= '0' && c <= '9' : c != '/'; });
  }
  return path == pattern;
}

bool is_known(std::string_view path) {
  const auto of_file = [&](const KnownFile& file) { return matches(path, file.path); };
  const auto of_folder = [&](std::string_view folder) { return matches(path, folder); };
  constexpr std::string_view kUnfinished = ".tmp";
  if (path.ends_with(kUnfinished)) {
    path.remove_suffix(kUnfinished.size());
    // Temporary files of replace_file, named with the process id.
    const std::size_t last = path.find_last_not_of("0123456789");
    path = last != std::string_view::npos && path[last] == '.' ? path.substr(0, last) : path;
  }
  return std::find(kDerivedFiles.begin(), kDerivedFiles.end(), path) != kDerivedFiles.end() ||
         std::any_of(kKnownFiles.begin(), kKnownFiles.end(), of_file) ||
         std::any_of(kKnownFolders.begin(), kKnownFolders.end(), of_folder);
}

bool is_run_folder(const fs::path& directory) {
  return begins_with(directory / "README.txt", std::string(kMarker) + "\n");
}

/// Removes the files of an earlier run. Folders with other files stay.
Status remove_earlier_run(const fs::path& directory) {
  std::error_code error;
  fs::remove_all(directory / ".spool", error);
  if (error) {
    return file_error("remove", directory / ".spool", error.value());
  }
  std::vector<fs::path> known;
  fs::recursive_directory_iterator entry(directory, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string path = entry->path().lexically_relative(directory).generic_string();
    if (is_known(path)) {
      known.push_back(entry->path());
    } else {
      entry.disable_recursion_pending();
    }
  }
  if (error) {
    return file_error("list", directory, error.value());
  }
  // run.json first, so that the folder no longer counts as complete; then deepest first, so that folders are empty.
  std::stable_partition(known.begin(), known.end(), [](const fs::path& path) { return path.filename() != "run.json"; });
  for (auto path = known.rbegin(); path != known.rend(); ++path) {
    fs::remove(*path, error);
    if (error && error != std::errc::directory_not_empty) {
      return file_error("remove", *path, error.value());
    }
  }
  return {};
}

Status check_is_folder(const fs::path& directory) {
  std::error_code error;
  const fs::file_status status = fs::status(directory, error);
  if (fs::exists(status) && !fs::is_directory(status)) {
    return fail(ErrorCode::kInvalidArgument,
                "cannot record to " + directory.string() + ": it is not a folder; name another one");
  }
  if (!fs::exists(status) && fs::is_symlink(fs::symlink_status(directory, error))) {
    return fail(ErrorCode::kInvalidArgument, "cannot record to " + directory.string() +
                                                 ": it is a link to a folder that does not exist; create that, or "
                                                 "name another one");
  }
  return {};
}

Result<FolderLock> lock_for_writing(const fs::path& directory) {
  FolderLock lock = FolderLock::take(directory, FolderUse::kWrite);
  if (lock.is_refused()) {
    return fail(ErrorCode::kInvalidArgument, "cannot record to " + directory.string() +
                                                 ": another run writes into it, or figure or evaluate reads it; wait "
                                                 "until that has ended, or name another folder");
  }
  return lock;
}

/// It is empty or holds an earlier run.
Status check_content(const fs::path& directory) {
  std::error_code error;
  const bool empty = fs::is_empty(directory, error);
  if (error) {
    return file_error("list", directory, error.value());
  }
  if (!empty && !is_run_folder(directory)) {
    return fail(ErrorCode::kInvalidArgument, "cannot record to " + directory.string() +
                                                 ": it holds files that are not an earlier run; name an empty or "
                                                 "new folder");
  }
  return {};
}

/// New files can be made in `directory`, or, where it is missing, folders in the nearest one above it.
Status check_writable(const fs::path& directory) {
  std::error_code error;
  if (fs::exists(directory, error)) {
    return check_replaceable(directory / "README.txt");
  }
  fs::path first = fs::absolute(directory, error).lexically_normal();
  first = first.has_filename() ? first : first.parent_path();
  while (first.parent_path().has_relative_path() && !fs::exists(first.parent_path(), error)) {
    first = first.parent_path();
  }
  // Permissions alone do not show whether a file system takes folders.
  if (fs::create_directory(first, error)) {
    fs::remove(first, error);
    return {};
  }
  return error ? Status(file_error("create", directory, error.value())) : Status{};
}

std::string readme_text(const RecordingConfig& config) {
  std::string text(kMarker);
  text +=
      "\nWorld = first left rectified camera: x right, y down, z forward, metres. A pose T_a_b maps b into a.\n"
      "ID is a track id, the same in every file. Without run.json the run was not finished.\n\n";
  for (const KnownFile& file : kKnownFiles) {
    if (enabled(file.part, config)) {
      text.append(file.path).append(std::max<std::size_t>(32, file.path.size() + 2) - file.path.size(), ' ');
      text.append(file.content).append("\n");
    }
  }
  return text;
}

}  // namespace

Status check_run_folder(const fs::path& directory) {
  std::error_code error;
  if (Status folder = check_is_folder(directory); !folder) {
    return folder;
  }
  if (fs::exists(directory, error)) {
    if (const Result<FolderLock> lock = lock_for_writing(directory); !lock) {
      return Unexpected(lock.error());
    }
    if (Status content = check_content(directory); !content) {
      return content;
    }
  }
  return check_writable(directory);
}

Result<FolderLock> prepare_run_folder(const RecordingConfig& config) {
  const fs::path& directory = config.directory;
  if (const Status folder = check_is_folder(directory); !folder) {
    return Unexpected(folder.error());
  }
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) {
    return file_error("create", directory, error.value());
  }
  Result<FolderLock> lock = lock_for_writing(directory);
  if (!lock) {
    return lock;
  }
  if (const Status content = check_content(directory); !content) {
    return Unexpected(content.error());
  }
  if (const Status removed = remove_earlier_run(directory); !removed) {
    return Unexpected(removed.error());
  }
  for (const auto& [folder, wanted] : {std::pair(".spool", true), std::pair("tracks", true),
                                       std::pair("points", config.points), std::pair("images", config.images)}) {
    if (wanted && !fs::create_directories(directory / folder, error) && error) {
      return file_error("create", directory / folder, error.value());
    }
  }
  if (const Status written = replace_file(directory / "README.txt", readme_text(config)); !written) {
    return Unexpected(written.error());
  }
  return lock;
}

std::vector<FileEntry> list_files(const RecordingConfig& config, const RunCounts& counts) {
  std::vector<FileEntry> files;
  for (const KnownFile& file : kKnownFiles) {
    const std::uint64_t count = file.count == nullptr ? 1 : counts.*file.count;
    if (enabled(file.part, config) && count > 0) {
      files.push_back({std::string(file.path), count});
      if (file.rows != nullptr) {
        files.back().rows = counts.*file.rows;
      }
    }
  }
  return files;
}

}  // namespace kinetrace::recording
