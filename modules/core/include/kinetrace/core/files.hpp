// Files and folders by name: errors for those that cannot be opened, and atomic replacement of files. For host-side
// tools; allocates.
#pragma once

#include <filesystem>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace {

/// The error for a file or folder that cannot be opened: kNotFound with `missing` if it does not exist, and with the
/// actual kind if the name belongs to something else; kIo with the reason if the path is obstructed (permissions of a
/// folder above it, a loop of links).
[[nodiscard]] KINETRACE_API Unexpected<Error> unreachable(const std::filesystem::path& path, std::string_view missing);

/// Checks that `path` is a folder whose files can be listed. Errors: as unreachable.
[[nodiscard]] KINETRACE_API Status check_folder(const std::filesystem::path& path, std::string_view missing);

/// Replaces `path` by `content` as a whole or not at all, even if power fails meanwhile. Devices and pipes are written
/// directly. Errors: kIo; the previous content is then intact.
[[nodiscard]] KINETRACE_API Status replace_file(const std::filesystem::path& path, std::string_view content);

/// Checks that a later `replace_file` can write into the folder and does not replace a folder: for files written at the
/// end of long work. Errors: kIo.
[[nodiscard]] KINETRACE_API Status check_replaceable(const std::filesystem::path& path);

/// Kind of a result's file.
struct FileKind {
  std::string_view name;  ///< For messages: "calibration in OpenCV's YAML".
  bool (*is_of_kind)(const std::filesystem::path& path) = nullptr;
};
/// A result replaces an earlier result only: checks that a file at `path`, if there is one with content, is of the
/// same kind. Devices and pipes pass. Errors: kOccupied.
[[nodiscard]] KINETRACE_API Status check_same_kind(const std::filesystem::path& path, const FileKind& kind);

/// Whether a file begins with this text.
[[nodiscard]] KINETRACE_API bool begins_with(const std::filesystem::path& path, std::string_view text);

/// Whether `path` is the folder or lies in it at any depth, also through links; neither has to exist.
[[nodiscard]] KINETRACE_API bool is_inside(const std::filesystem::path& path, const std::filesystem::path& folder);

/// For writers that take a name: the file to write that shall replace `path`, and the rename after writing.
/// `staged_path` is `path` itself for a device or a pipe. Errors: kIo; the staged file is then removed.
[[nodiscard]] KINETRACE_API std::filesystem::path staged_path(const std::filesystem::path& path);
/// Opens it for writing: a descriptor, or -1 and errno; ENXIO for a pipe without a reader.
[[nodiscard]] KINETRACE_API int open_staged(const std::filesystem::path& staged) noexcept;
[[nodiscard]] KINETRACE_API Status put_in_place(const std::filesystem::path& staged, const std::filesystem::path& path);
/// Removes the staged file of `path` after a failed write. A device or a pipe stays.
KINETRACE_API void discard_staged(const std::filesystem::path& staged, const std::filesystem::path& path);

}  // namespace kinetrace
