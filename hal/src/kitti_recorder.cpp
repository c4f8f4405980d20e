#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <unistd.h>

#include "calibration_text.hpp"
#include "container_file.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "messages.hpp"
#include "raw_recorders.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::array<const char*, 2> kEyes{"image_00", "image_01"};

// "2011-09-26 14:06:03.368359168\n".
using TimeText = std::array<char, 48>;
int format_time(std::int64_t time_ns, TimeText& text) {
  const std::time_t seconds = time_ns / kSecond_ns;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return std::snprintf(text.data(), text.size(), "%04d-%02d-%02d %02d:%02d:%02d.%09d\n", parts.tm_year + 1900,
                       parts.tm_mon + 1, parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec,
                       static_cast<int>(time_ns % kSecond_ns));
}

// Cameras count from when the machine was switched on; KITTI's times are dates.
std::int64_t epoch_of(std::int64_t first_ns) {
  constexpr std::int64_t kSurelyADate_ns = 1'000'000'000 * kSecond_ns;
  if (first_ns >= kSurelyADate_ns) {
    return 0;
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - first_ns;
}

class KittiRecorder final : public RawRecorder {
 public:
  KittiRecorder(const RawRecorderConfig& config, fs::path drive)
      : config_(config),
        drive_(std::move(drive)),
        width_px_(config.calibration.raw_width_px()),
        height_px_(config.calibration.raw_height_px()),
        path_(drive_.string().size() + kLongestName) {}

  Status begin(const std::string& calibration) {
    std::error_code error;
    for (std::size_t eye = 0; eye < kEyes.size(); ++eye) {
      fs::create_directories(drive_ / kEyes[eye] / "data", error);
      const fs::path times = drive_ / kEyes[eye] / "timestamps.txt";
      times_[eye] = OwnedFd(::open(times.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
      if (error || !times_[eye].valid()) {
        return fail(ErrorCode::kIo, concat(times.string(), ": cannot be made: ", std::strerror(errno)));
      }
    }
    const fs::path file = config_.directory / "calib_cam_to_cam.txt";
    std::ofstream stream(file);
    stream << calibration;
    stream.close();
    return stream ? Status{} : fail(ErrorCode::kIo, file.string() + ": cannot be written; check space and permissions");
  }

  Status write(const StereoFrame& frame) override {
    if (stopped_) {
      return tl::unexpected(*stopped_);
    }
    Status written = check_frame(frame);
    const std::array<GrayView, 2> images{frame.left, frame.right};
    for (std::size_t eye = 0; written && eye < kEyes.size(); ++eye) {
      std::snprintf(path_.data(), path_.size(), "%s/%s/data/%010lld.png", drive_.c_str(), kEyes[eye],
                    static_cast<long long>(frame.frame_index));
      written = imaging::write_png_gray8(path_.data(), images[eye], imaging::PngEffort::kFast);
    }
    if (written) {
      written = write_times(frame.timestamp_ns);
    }
    if (!written) {
      stopped_ = written.error();
      return written;
    }
    ++frames_;
    return {};
  }

  Status sync() override {
    for (const OwnedFd& times : times_) {
      if (syncfs(times.get()) != 0) {
        return fail(ErrorCode::kIo, concat(drive_.string(), ": cannot be written: ", std::strerror(errno)));
      }
    }
    return {};
  }

  std::int64_t frames() const noexcept override { return frames_; }

 private:
  static constexpr std::size_t kLongestName = 64;
  static constexpr std::int64_t kFramesBetweenChecks = 16;

  Status check_frame(const StereoFrame& frame) {
    for (const GrayView& image : {frame.left, frame.right}) {
      if (image.width != width_px_ || image.height != height_px_) {
        return fail(ErrorCode::kInvalidArgument,
                    concat(drive_.string(), ": an image is ", size_text(image.width, image.height),
                           "; all of a recording have one size"));
      }
    }
    return frames_ % kFramesBetweenChecks == 0 ? check_space(drive_, config_.keep_free_bytes) : Status{};
  }

  Status write_times(std::int64_t timestamp_ns) {
    if (!epoch_ns_) {
      epoch_ns_ = epoch_of(timestamp_ns);
    }
    TimeText text{};
    const int length = format_time(timestamp_ns + *epoch_ns_, text);
    for (const OwnedFd& times : times_) {
      if (::write(times.get(), text.data(), static_cast<std::size_t>(length)) != length) {
        return fail(ErrorCode::kIo, concat(drive_.string(), ": ", std::strerror(errno != 0 ? errno : ENOSPC)));
      }
    }
    return {};
  }

  RawRecorderConfig config_;
  fs::path drive_;
  int width_px_;
  int height_px_;
  std::vector<char> path_;
  std::array<OwnedFd, 2> times_;
  std::optional<std::int64_t> epoch_ns_;  ///< Added to all times.
  std::int64_t frames_ = 0;
  std::optional<Error> stopped_;
};

}  // namespace

Result<std::unique_ptr<RawRecorder>> make_kitti_recorder(const RawRecorderConfig& config) {
  const Result<std::string> calibration = kitti_calibration_text(config.calibration);
  if (!calibration) {
    return tl::unexpected(calibration.error());
  }
  // As KITTI names them: images as the sensor gave them, or rectified ones.
  const fs::path drive = config.directory / (config.calibration.rectified ? "drive_0001_sync" : "drive_0001_extract");
  auto recorder = std::make_unique<KittiRecorder>(config, drive);
  if (const Status begun = recorder->begin(*calibration); !begun) {
    return tl::unexpected(begun.error());
  }
  return recorder;
}

}  // namespace kinetrace::hal
