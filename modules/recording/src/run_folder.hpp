// The folder of a run: which files it holds, and how an earlier run in it gives way.
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

/// Where a run in progress says what it is made from; it goes when run.json has come.
inline constexpr std::string_view kBegunPath = ".spool/run.json";

/// One kind of file of a run that has been finished.
struct FileEntry {
  std::string path;                                  ///< "ID" stands for a track id.
  std::uint64_t count = 1;                           ///< Files of this kind.
  std::optional<std::uint64_t> rows = std::nullopt;  ///< Of one file, where readers are to miss none.
};

/// Makes `config.directory` ready: created, or cleared of the files of an earlier run. Nothing else is touched. The
/// folder stays this run's while the lock lives. Errors: kInvalidArgument (in use; holds something else), kIo.
[[nodiscard]] Result<FolderLock> prepare_run_folder(const RecordingConfig& config);
/// What a run with this configuration has left behind, for run.json.
[[nodiscard]] std::vector<FileEntry> list_files(const RecordingConfig& config, const RunCounts& counts);

}  // namespace kinetrace::recording
