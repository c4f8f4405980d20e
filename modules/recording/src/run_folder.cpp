#include "run_folder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <unistd.h>

#include "buffered_file.hpp"

namespace kinetrace::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMarker = "Kinetrace run folder";  // First line of README.txt.

enum class Part { kAlways, kMots, kPoints, kColmap };

struct KnownFile {
  std::string_view path;  ///< "ID" stands for a track id.
  Part part;
  std::string_view content;
  std::uint64_t ConversionCounts::*count = nullptr;  ///< How many there are, if not one.
};

constexpr std::array<KnownFile, 17> kKnownFiles{{
    {"README.txt", Part::kAlways, "this overview"},
    {"run.json", Part::kAlways, "version, configuration, timings, memory, counters, warnings; written last"},
    {"camera.tum", Part::kAlways, "camera in the world per frame: timestamp tx ty tz qx qy qz qw"},
    {"camera_kitti.txt", Part::kAlways, "the same as KITTI poses: 12 numbers, row-major 3 x 4"},
    {"objects.csv", Part::kAlways, "every object in every frame: pose, velocity, box, covariance, counts"},
    {"label_02.txt", Part::kAlways, "the same as KITTI tracking labels, camera frame"},
    {"mots.txt", Part::kMots, "tracked left masks in KITTI MOTS format"},
    {"tracks/ID.tum", Part::kAlways, "object ID in the world per frame, as camera.tum", &ConversionCounts::tracks},
    {"points/background.ply", Part::kPoints, "background points, world frame"},
    {"points/object_ID.ply", Part::kPoints, "points of object ID at every frame, world frame",
     &ConversionCounts::object_clouds},
    {"points/object_ID_model.ply", Part::kPoints, "points of object ID, object frame",
     &ConversionCounts::object_clouds},
    {"colmap/background/cameras.txt", Part::kColmap, "COLMAP text model of the background"},
    {"colmap/background/images.txt", Part::kColmap, "its images"},
    {"colmap/background/points3D.txt", Part::kColmap, "its points"},
    {"colmap/object_ID/cameras.txt", Part::kColmap, "COLMAP text model of object ID", &ConversionCounts::object_models},
    {"colmap/object_ID/images.txt", Part::kColmap, "its images", &ConversionCounts::object_models},
    {"colmap/object_ID/points3D.txt", Part::kColmap, "its points", &ConversionCounts::object_models},
}};
constexpr std::array<std::string_view, 5> kKnownFolders{"tracks", "points", "colmap", "colmap/background",
                                                        "colmap/object_ID"};

bool enabled(Part part, const RecordingConfig& config) {
  switch (part) {
    case Part::kAlways: return true;
    case Part::kMots: return config.mots;
    case Part::kPoints: return config.points;
    case Part::kColmap: return config.colmap;
  }
  return false;
}

/// `path` equals `pattern` with digits in the place of "ID".
bool matches(std::string_view path, std::string_view pattern) {
  const std::size_t id = pattern.find("ID");
  if (id == std::string_view::npos) {
    return path == pattern;
  }
  const std::string_view before = pattern.substr(0, id);
  const std::string_view after = pattern.substr(id + 2);
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after)) {
    return false;
  }
  const std::string_view digits = path.substr(before.size(), path.size() - before.size() - after.size());
  return std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_known(std::string_view path) {
  const auto of_file = [&](const KnownFile& file) { return matches(path, file.path); };
  const auto of_folder = [&](std::string_view folder) { return matches(path, folder); };
  // An evaluation or a picture of the earlier run would be taken for one of the new run.
  return path == "run.json.tmp" || path == "evaluation.json" || path == "figure.png" ||
         std::any_of(kKnownFiles.begin(), kKnownFiles.end(), of_file) ||
         std::any_of(kKnownFolders.begin(), kKnownFolders.end(), of_folder);
}

bool is_run_folder(const fs::path& directory) {
  std::ifstream readme(directory / "README.txt");
  std::string line;
  return std::getline(readme, line) && line == kMarker;
}

/// Removes what an earlier run wrote. Folders stay if somebody else's files are in them.
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
  // Deepest first, so that folders are empty when their turn comes.
  for (auto path = known.rbegin(); path != known.rend(); ++path) {
    fs::remove(*path, error);
    if (error && error != std::errc::directory_not_empty) {
      return file_error("remove", *path, error.value());
    }
  }
  return {};
}

Status write_text(const fs::path& path, std::string_view text) {
  Result<FileHandle> file = open_file(path, OpenMode::kCreate);
  if (!file) {
    return Unexpected(file.error());
  }
  if (Status written = write_at(*file, 0, std::as_bytes(std::span(text)), path); !written) {
    return written;
  }
  if (::fsync(file->get()) != 0) {
    return file_error("write", path, errno);
  }
  const int close_error = file->close();
  return close_error == 0 ? Status{} : Status(file_error("write", path, close_error));
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

Status prepare_run_folder(const RecordingConfig& config) {
  const fs::path& directory = config.directory;
  std::error_code error;
  const fs::file_status status = fs::status(directory, error);
  if (fs::exists(status) && !fs::is_directory(status)) {
    return fail(ErrorCode::kInvalidArgument,
                "cannot record to " + directory.string() + ": it is not a folder; name another one");
  }
  if (fs::exists(status)) {
    const bool empty = fs::is_empty(directory, error);
    if (error) {
      return file_error("list", directory, error.value());
    }
    if (!empty && !is_run_folder(directory)) {
      return fail(ErrorCode::kInvalidArgument, "cannot record to " + directory.string() +
                                                   ": it holds files that are not an earlier run; name an empty or "
                                                   "new folder");
    }
    if (Status removed = remove_earlier_run(directory); !removed) {
      return removed;
    }
  }
  for (const std::string_view folder : {".spool", "tracks", "points"}) {
    if (folder != "points" || config.points) {
      fs::create_directories(directory / folder, error);
      if (error) {
        return file_error("create", directory / folder, error.value());
      }
    }
  }
  return write_text(directory / "README.txt", readme_text(config));
}

std::vector<FileEntry> list_files(const RecordingConfig& config, const ConversionCounts& counts) {
  std::vector<FileEntry> files;
  for (const KnownFile& file : kKnownFiles) {
    const std::uint64_t count = file.count == nullptr ? 1 : counts.*file.count;
    if (enabled(file.part, config) && count > 0) {
      files.push_back({std::string(file.path), count});
    }
  }
  return files;
}

Status write_atomically(const fs::path& path, std::string_view text) {
  const fs::path temporary = path.string() + ".tmp";
  if (Status written = write_text(temporary, text); !written) {
    return written;
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) {
    return file_error("replace", path, error.value());
  }
  // The new name lasts only once the folder itself is on disk.
  const Result<FileHandle> folder = open_file(path.parent_path(), OpenMode::kRead);
  if (!folder) {
    return Unexpected(folder.error());
  }
  return ::fsync(folder->get()) == 0 || errno == EINVAL ? Status{} : Status(file_error("write", path, errno));
}

}  // namespace kinetrace::recording
