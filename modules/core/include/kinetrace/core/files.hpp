// Files and folders by name: why one cannot be had, and files written so that a reader finds the old content or the new
// one. For host-side tools; allocates.
#pragma once

#include <filesystem>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace {

/// The error for a file or folder that cannot be had: kNotFound with `missing` where there is none, and with its kind
/// where something else has the name; kIo with the reason where something is in the way (permissions of a folder above
/// it, a loop of links).
[[nodiscard]] KINETRACE_API Unexpected<Error> unreachable(const std::filesystem::path& path, std::string_view missing);

/// That `path` is a folder whose files can be listed. Errors: as unreachable.
[[nodiscard]] KINETRACE_API Status check_folder(const std::filesystem::path& path, std::string_view missing);

/// Writes `content` in the place of `path` as a whole or not at all, even if power fails meanwhile. Devices and pipes
/// are written to as they are. Errors: kIo; what was there before is then still there.
[[nodiscard]] KINETRACE_API Status replace_file(const std::filesystem::path& path, std::string_view content);

/// That a later `replace_file` has a folder to write into and no folder in its place: for files that are written at the
/// end of long work. Errors: kIo.
[[nodiscard]] KINETRACE_API Status check_replaceable(const std::filesystem::path& path);

/// For writers that take a name: where to write what shall replace `path`, and the rename once it is written.
/// `staged_path` is `path` itself where that is a device or a pipe. Errors: kIo; the staged file is then removed.
[[nodiscard]] KINETRACE_API std::filesystem::path staged_path(const std::filesystem::path& path);
/// Opens it for writing: a descriptor, or -1 and errno; ENXIO for a pipe that nobody reads.
[[nodiscard]] KINETRACE_API int open_staged(const std::filesystem::path& staged) noexcept;
[[nodiscard]] KINETRACE_API Status put_in_place(const std::filesystem::path& staged, const std::filesystem::path& path);
/// Removes what was staged for `path` and could not be written. A device or a pipe that was written to stays.
KINETRACE_API void discard_staged(const std::filesystem::path& staged, const std::filesystem::path& path);

}  // namespace kinetrace
