#include "study/study_recording.hpp"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "kinetrace/core/files.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

/// The only drive in a folder made by kinetrace-simulate.
Outcome<fs::path> find_drive(const fs::path& recording) {
  std::vector<fs::path> drives;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(recording, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (entry.depth() == 1 && (name.ends_with("_sync") || name.ends_with("_extract"))) {
      drives.push_back(entry->path());
    }
    if (entry.depth() == 1) {
      entry.disable_recursion_pending();
    }
  }
  if (drives.size() != 1) {
    return Unexpected(Failure{ExitCode::kNoInput, recording.string() + ": expected one drive and its truth, as "
                                                                       "kinetrace-simulate makes them"});
  }
  return drives.front();
}

}  // namespace

Status check_study_recordings(const std::vector<fs::path>& recordings) {
  for (auto recording = recordings.begin(); recording != recordings.end(); ++recording) {
    if (Status there = check_folder(*recording, "no such recording; kinetrace-simulate makes them"); !there) {
      return there;
    }
    const auto is_same = [&](const fs::path& earlier) {
      std::error_code error;
      return fs::equivalent(earlier, *recording, error);
    };
    if (const auto first = std::find_if(recordings.begin(), recording, is_same); first != recording) {
      return fail(ErrorCode::kInvalidArgument, recording->string() + ": is the recording " + first->string() +
                                                   " again, which would count twice; name each one once");
    }
  }
  return {};
}

Outcome<StudyRecording> open_study_recording(const fs::path& path, const std::string& masks) {
  const Outcome<fs::path> drive = find_drive(path);
  if (!drive) {
    return Unexpected(drive.error());
  }
  hal::DatasetSpec spec;
  spec.layout = hal::DatasetLayout::kKittiRaw;
  spec.path = *drive;
  Result<hal::Dataset> dataset = hal::open_dataset(spec);
  if (!dataset) {
    return failure(dataset.error());
  }
  Result<StudyTruth> truth = StudyTruth::open(path);
  if (!truth) {
    return failure(truth.error());
  }
  const fs::path folder = path / "truth" / "masks";
  return StudyRecording{path.string(), std::move(*dataset),
                        "masks:" + (folder / (masks + "_left")).string() + "," + (folder / (masks + "_right")).string(),
                        std::move(*truth)};
}

Status make_study_folder(const fs::path& directory, const std::vector<fs::path>& recordings) {
  for (const fs::path& recording : recordings) {
    if (is_inside(directory, recording)) {
      return fail(ErrorCode::kOccupied, directory.string() + ": lies in the recording " + recording.string() +
                                            "; name another folder for the study");
    }
  }
  std::error_code error;
  fs::create_directories(directory, error);
  return error ? fail(ErrorCode::kIo, directory.string() + ": cannot be made (" + error.message() + ")") : Status{};
}

}  // namespace kinetrace::app
