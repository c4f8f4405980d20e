// The run folder: its files, and removal of an earlier run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "folder_lock.hpp"
#include "kinetrace/core/result.hpp"
#include "spool.hpp"

namespace kinetrace::recording {

/// Description of a run in progress; removed after run.json is written.
inline constexpr std::string_view kBegunPath = ".spool/run.json";

/// One kind of file of a finished run.
struct FileEntry {
  std::string path;                                  ///< "ID" stands for a track id.
  std::uint64_t count = 1;                           ///< Files of this kind.
  std::optional<std::uint64_t> rows = std::nullopt;  ///< Rows of the file, if readers check for missing ones.
};

/// Whether a run can be written to `directory`. Leaves it as it is; where it is missing, one is made and removed again.
/// Errors: as prepare_run_folder.
[[nodiscard]] Status check_run_folder(const std::filesystem::path& directory);
/// Prepares `config.directory`: creates it, or removes the files of an earlier run and nothing else. The lock reserves
/// the folder for this run. Errors: kInvalidArgument (in use; holds something else), kIo.
[[nodiscard]] Result<FolderLock> prepare_run_folder(const RecordingConfig& config);
/// The files of a run with this configuration, for run.json.
[[nodiscard]] std::vector<FileEntry> list_files(const RecordingConfig& config, const RunCounts& counts);

}  // namespace kinetrace::recording
