#include "kinetrace/hal/raw_recorder.hpp"

#include <cerrno>
#include <string>
#include <sys/statvfs.h>
#include <system_error>
#include <unistd.h>

#include "formats/calibration_text.hpp"
#include "kinetrace/core/config_check.hpp"
#include "recording/append_file.hpp"
#include "recording/raw_recorders.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

Unexpected<Error> not_made(const fs::path& directory, const std::error_code& error) {
  return fail(ErrorCode::kIo, concat(directory.string(), ": cannot be made: ", error.message()));
}

// Never into a folder that is not empty: a recording cannot be repeated.
Status check_folder(const fs::path& directory) {
  std::error_code error;
  fs::path above = fs::absolute(directory, error);
  while (!fs::exists(above, error) && above.has_relative_path()) {
    above = above.parent_path();
  }
  if (!fs::is_directory(above, error)) {
    return not_made(directory, error ? error : std::make_error_code(std::errc::not_a_directory));
  }
  if (::access(above.c_str(), W_OK | X_OK) != 0) {
    return not_made(directory, std::error_code(errno, std::generic_category()));
  }
  if (fs::exists(directory, error) && !fs::is_empty(directory, error)) {
    return fail(ErrorCode::kInvalidArgument,
                directory.string() + ": is not empty; recordings are never written over, name a new folder");
  }
  return {};
}

Status make_folder(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  return error ? Status(not_made(directory, error)) : Status{};
}

}  // namespace

Status RawRecorderConfig::validate() const {
  if (directory.empty()) {
    return fail(ErrorCode::kInvalidConfig, "the folder of the raw recording has no name");
  }
  return first_failure(
      {check_range("rate_hz", rate_hz, 0.0, 1e5),
       check_range<std::uint64_t>("segment_bytes", segment_bytes, 1U << 20U, std::uint64_t{1} << 50U)});
}

Status check_space(const fs::path& folder, std::uint64_t keep_free_bytes, std::uint64_t needed_bytes) {
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) {
    return fail(ErrorCode::kIo, folder.string() + ": has gone; check the drive");
  }
  const std::uint64_t free_bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  if (free_bytes < needed_bytes || free_bytes - needed_bytes < keep_free_bytes) {
    return fail(ErrorCode::kIo, concat(folder.string(), ": the disk is full (", std::to_string(keep_free_bytes >> 20U),
                                       " MiB are kept free); make room"));
  }
  return {};
}

std::size_t RawRecorder::required_bytes(const RawRecorderConfig& config) {
  return config.format == RawFormat::kContainer ? container_recorder_bytes(config) : 0;
}

Status RawRecorder::check(const RawRecorderConfig& config) {
  if (Status usable = first_failure({config.validate(), check_folder(config.directory)});
      !usable || config.format == RawFormat::kContainer) {
    return usable;
  }
  const Result<std::string> calibration = kitti_calibration_text(config.calibration);
  return calibration ? Status{} : Unexpected(calibration.error());
}

Result<std::unique_ptr<RawRecorder>> RawRecorder::create(const RawRecorderConfig& config, Arena& arena) {
  Status made = check(config);
  made = made ? make_folder(config.directory) : made;
  if (!made) {
    return Unexpected(made.error());
  }
  auto recorder =
      config.format == RawFormat::kContainer ? make_container_recorder(config, arena) : make_kitti_recorder(config);
  // Syncs folders, calibration and first headers: frames are useless without them.
  if (const Status lasts = sync_disk_of(config.directory.c_str()); recorder && !lasts) {
    return Unexpected(lasts.error());
  }
  return recorder;
}

}  // namespace kinetrace::hal
