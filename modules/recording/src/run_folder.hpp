// The folder of a run: which files it holds, and how an earlier run in it gives way.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "spool.hpp"

namespace kinetrace::recording {

/// One kind of file of a run that has been finished.
struct FileEntry {
  std::string path;         ///< "ID" stands for a track id.
  std::uint64_t count = 1;  ///< Files of this kind.
};

/// Makes `config.directory` ready: created, or cleared of the files of an earlier run. Nothing else is touched.
[[nodiscard]] Status prepare_run_folder(const RecordingConfig& config);
/// What a run with this configuration has left behind, for run.json.
[[nodiscard]] std::vector<FileEntry> list_files(const RecordingConfig& config, const ConversionCounts& counts);
/// Replaces `path` as a whole or not at all, even if power fails meanwhile.
[[nodiscard]] Status write_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace kinetrace::recording
