#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <unistd.h>
#include <utility>
#include <vector>

#include "dataset/layouts.hpp"
#include "formats/calibration_text.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "recording/append_file.hpp"
#include "recording/raw_recorders.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::array<const char*, 2> kViews{"image_00", "image_01"};

// "2011-09-26 14:06:03.368359168\n".
using LineText = std::array<char, 48>;
// The C library's gmtime would allocate.
int format_date(std::int64_t time_ns, LineText& text) {
  const std::chrono::sys_time<std::chrono::nanoseconds> moment{std::chrono::nanoseconds(time_ns)};
  const auto day = std::chrono::floor<std::chrono::days>(moment);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(moment - day);
  return std::snprintf(text.data(), text.size(), "%04d-%02u-%02u %02d:%02d:%02d.%09d\n", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                       static_cast<int>(time.seconds().count()), static_cast<int>(time.subseconds().count()));
}

// Camera times count from the start of the machine; KITTI's times are dates.
std::int64_t epoch_of(std::int64_t first_ns) {
  constexpr std::int64_t kSurelyADate_ns = 1'000'000'000 * kSecond_ns;
  if (first_ns >= kSurelyADate_ns) {
    return 0;
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - first_ns;
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

// Beside KITTI's own files, frames.txt maps frame numbers to times: its lines are written last, and a frame without a
// line does not count. KITTI relates images and lines of times by their count alone, which is wrong after a loss of
// power.
class KittiRecorder final : public RawRecorder {
 public:
  KittiRecorder(const RawRecorderConfig& config, fs::path drive)
      : config_(config),
        drive_(std::move(drive)),
        width_px_(config.calibration.raw_width_px()),
        height_px_(config.calibration.raw_height_px()),
        path_(drive_.string().size() + kMaxName),
        unfinished_path_(path_.size()) {}

  Status begin(const std::string& calibration) {
    for (std::size_t view = 0; view < kViews.size(); ++view) {
      std::error_code error;
      if (fs::create_directories(drive_ / kViews[view] / "data", error); error) {
        return fail(ErrorCode::kIo, concat(drive_.string(), ": cannot be made: ", error.message()));
      }
      if (Status made = make(drive_ / kViews[view] / "timestamps.txt", "", lines_[view]); !made) {
        return made;
      }
    }
    AppendFile calibration_file;
    return first_failure({make(drive_ / kFrameTimesFile, "# frame, time in ns\n", lines_[kFrameTimes]),
                          make(config_.directory / "calib_cam_to_cam.txt", calibration, calibration_file)});
  }

  Status write(const StereoFrame& frame) override {
    if (stopped_) {
      return Unexpected(*stopped_);
    }
    Status written = check_frame(frame);
    if (written) {
      written = write_whole(frame);
    }
    if (!written) {
      stopped_ = written.error();
      return written;
    }
    ++frames_;
    return {};
  }

  // Syncing every image of a second by itself would take more than a second.
  Status sync() override { return sync_disk_of(drive_.c_str()); }

  std::int64_t frames() const noexcept override { return frames_; }

 private:
  static constexpr std::size_t kMaxName = 64;
  /// Per frame: headers, checksums, lines of times, and the growth of incompressible images.
  static constexpr std::uint64_t kBytesBesidePixels = 16384;
  static constexpr std::size_t kFrameTimes = kViews.size();

  static Status make(const fs::path& path, std::string_view content, AppendFile& file) {
    auto made = AppendFile::create(path.c_str());
    if (!made) {
      return Unexpected(made.error());
    }
    file = std::move(*made);
    const Status written = file.append(bytes_of(content));
    return written ? written : fail(ErrorCode::kIo, concat(path.string(), ": ", written.error().message));
  }

  Status check_frame(const StereoFrame& frame) {
    for (const GrayView& image : {frame.left, frame.right}) {
      if (image.width != width_px_ || image.height != height_px_) {
        return fail(ErrorCode::kInvalidArgument,
                    concat(drive_.string(), ": an image is ", size_text(image.width, image.height),
                           "; all of a recording have one size"));
      }
    }
    // Upper bound: even incompressible noise takes hardly more.
    const std::uint64_t pixels = static_cast<std::uint64_t>(width_px_) * static_cast<std::uint64_t>(height_px_);
    return check_space(drive_, config_.keep_free_bytes, 2 * pixels + kBytesBesidePixels);
  }

  // All or nothing.
  Status write_whole(const StereoFrame& frame) {
    std::array<std::uint64_t, kViews.size() + 1> bytes_before{};
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      bytes_before[i] = lines_[i].bytes();
    }
    Status written = write_image(0, frame.frame_index, frame.left);
    if (written) {
      written = write_image(1, frame.frame_index, frame.right);
    }
    if (written) {
      written = write_times(frame);
    }
    if (!written) {
      for (std::size_t i = 0; i < lines_.size(); ++i) {
        lines_[i].cut(bytes_before[i]);
      }
      for (std::size_t view = 0; view < kViews.size(); ++view) {
        compose_paths(view, frame.frame_index);
        static_cast<void>(::unlink(path_.data()));
      }
      written.error().message += "; what was recorded before is whole";
    }
    return written;
  }

  void compose_paths(std::size_t view, std::int64_t number) {
    for (const auto& [path, suffix] : {std::pair{&path_, "png"}, std::pair{&unfinished_path_, "part"}}) {
      std::snprintf(path->data(), path->size(), "%s/%s/data/%010lld.%s", drive_.c_str(), kViews[view],
                    static_cast<long long>(number), suffix);
    }
  }

  // An image gets its name once it is complete.
  Status write_image(std::size_t view, std::int64_t number, const GrayView& image) {
    compose_paths(view, number);
    Status written = imaging::write_png_gray8(unfinished_path_.data(), image, imaging::PngEffort::kFast);
    if (written && std::rename(unfinished_path_.data(), path_.data()) != 0) {
      return fail(ErrorCode::kIo, concat(path_.data(), ": ", std::strerror(errno)));
    }
    return written;
  }

  Status write_times(const StereoFrame& frame) {
    if (!epoch_ns_) {
      epoch_ns_ = epoch_of(frame.timestamp_ns);
    }
    const std::int64_t time_ns = frame.timestamp_ns + *epoch_ns_;
    LineText text{};
    Status written;
    for (std::size_t i = 0; written && i < lines_.size(); ++i) {
      const int length = i == kFrameTimes
                             ? std::snprintf(text.data(), text.size(), "%lld %lld\n",
                                             static_cast<long long>(frame.frame_index), static_cast<long long>(time_ns))
                             : format_date(time_ns, text);
      written = lines_[i].append(bytes_of({text.data(), static_cast<std::size_t>(length)}));
    }
    return written ? written : fail(ErrorCode::kIo, concat(drive_.string(), ": ", written.error().message));
  }

  RawRecorderConfig config_;
  fs::path drive_;
  int width_px_;
  int height_px_;
  std::vector<char> path_;
  std::vector<char> unfinished_path_;
  std::array<AppendFile, kViews.size() + 1> lines_;  ///< Times of both views, and times by frame number.
  std::optional<std::int64_t> epoch_ns_;             ///< Added to all times.
  std::int64_t frames_ = 0;
  std::optional<Error> stopped_;
};

}  // namespace

Result<std::unique_ptr<RawRecorder>> make_kitti_recorder(const RawRecorderConfig& config) {
  const Result<std::string> calibration = kitti_calibration_text(config.calibration);
  if (!calibration) {
    return Unexpected(calibration.error());
  }
  // KITTI's names: `sync` for rectified images, `extract` for raw ones.
  const fs::path drive = config.directory / (config.calibration.rectified ? "drive_0001_sync" : "drive_0001_extract");
  auto recorder = std::make_unique<KittiRecorder>(config, drive);
  if (const Status begun = recorder->begin(*calibration); !begun) {
    return Unexpected(begun.error());
  }
  return recorder;
}

}  // namespace kinetrace::hal
