#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

#include "formats/calibration_text.hpp"
#include "formats/container_file.hpp"
#include "kinetrace/core/crc32.hpp"
#include "recording/append_file.hpp"
#include "recording/raw_recorders.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

class ContainerRecorder final : public RawRecorder {
 public:
  ContainerRecorder(const RawRecorderConfig& config, std::string header, std::span<std::byte> record)
      : config_(config),
        width_px_(config.calibration.raw_width_px()),
        height_px_(config.calibration.raw_height_px()),
        header_(std::move(header)),
        record_(record),
        folder_(config.directory.string()) {
    path_.reserve(folder_.size() + kMaxName);
  }

  Status begin_segment() {
    if (file_.valid()) {
      if (Status synced = sync(); !synced) {
        return synced;
      }
    }
    std::array<char, kMaxName> name{};
    std::snprintf(name.data(), name.size(), "/%06d%s", segments_, kContainerSuffix);
    path_.assign(folder_).append(name.data());
    auto file = AppendFile::create(path_.c_str());
    if (!file) {
      return Unexpected(file.error());
    }
    file_ = std::move(*file);
    ++segments_;
    const Status begun = append(std::as_bytes(std::span(header_)));
    // If a loss of power took the name of a file, its synced content would be lost, too.
    return begun ? sync_folder(folder_.c_str()) : begun;
  }

  Status write(const StereoFrame& frame) override {
    if (stopped_) {
      return Unexpected(*stopped_);
    }
    Status written = fill_record(frame);
    if (written) {
      // The record may be the first of a new file.
      written = check_space(config_.directory, config_.keep_free_bytes, header_.size() + record_.size());
    }
    if (written && file_.bytes() + record_.size() >
                       std::max<std::uint64_t>(config_.segment_bytes, header_.size() + record_.size())) {
      written = begin_segment();
    }
    if (written) {
      written = append(record_);
    }
    if (!written) {
      stopped_ = written.error();
      return written;
    }
    ++frames_;
    return {};
  }

  Status sync() override {
    const Status synced = file_.sync();
    return synced ? synced : fail(ErrorCode::kIo, concat(path_, ": cannot be written: ", synced.error().message));
  }

  std::int64_t frames() const noexcept override { return frames_; }

 private:
  static constexpr std::size_t kMaxName = 32;

  Status fill_record(const StereoFrame& frame) {
    std::byte* at = record_.data() + kRecordHeaderBytes;
    for (const GrayView& image : {frame.left, frame.right}) {
      const auto row_bytes = static_cast<std::size_t>(image.width);
      if (image.width != width_px_ || image.height != height_px_) {
        return fail(ErrorCode::kInvalidArgument, concat(path_, ": an image is ", size_text(image.width, image.height),
                                                        "; all of a recording have one size"));
      }
      for (int y = 0; y < image.height; ++y) {
        std::memcpy(at, image.row(y), row_bytes);
        at += row_bytes;
      }
    }
    const std::uint32_t crc = Crc32().update(record_.subspan(kRecordHeaderBytes)).value();
    encode_record_header({frame.frame_index, frame.timestamp_ns, crc}, record_.first<kRecordHeaderBytes>());
    return {};
  }

  Status append(std::span<const std::byte> bytes) {
    const Status appended = file_.append(bytes);
    return appended ? appended
                    : fail(ErrorCode::kIo,
                           concat(path_, ": ", appended.error().message, "; what was recorded before is whole"));
  }

  RawRecorderConfig config_;
  int width_px_;
  int height_px_;
  std::string header_;
  std::span<std::byte> record_;
  std::string folder_;
  std::string path_;
  AppendFile file_;
  std::int64_t frames_ = 0;
  int segments_ = 0;
  std::optional<Error> stopped_;
};

}  // namespace

std::size_t container_recorder_bytes(const RawRecorderConfig& config) {
  return measure_bytes([&config](Arena& arena) {
    static_cast<void>(
        arena.take<std::byte>(record_bytes(config.calibration.raw_width_px(), config.calibration.raw_height_px())));
  });
}

Result<std::unique_ptr<RawRecorder>> make_container_recorder(const RawRecorderConfig& config, Arena& arena) {
  const int width_px = config.calibration.raw_width_px();
  const int height_px = config.calibration.raw_height_px();
  auto header = encode_header({width_px, height_px, config.rate_hz, calibration_text(config.calibration)});
  if (!header) {
    return Unexpected(header.error());
  }
  const std::span<std::byte> record = arena.take<std::byte>(record_bytes(width_px, height_px));
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the raw recorder; enlarge the memory budget");
  }
  auto recorder = std::make_unique<ContainerRecorder>(config, std::move(*header), record);
  if (const Status begun = recorder->begin_segment(); !begun) {
    return Unexpected(begun.error());
  }
  return recorder;
}

}  // namespace kinetrace::hal
