// A recording that behaves like a camera.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/stereo_camera.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::hal {

struct KINETRACE_API FileCameraConfig {
  int passes = 1;        ///< How often the recording is played; frame numbers and times keep increasing.
  int max_warnings = 8;  ///< Messages kept about skipped frames; all are counted.

  [[nodiscard]] Status validate() const;
};

/// Plays a Dataset at the caller's pace: `next` decodes and never waits. Frames with a missing side and frames that
/// cannot be decoded are skipped and counted. A missing folder (an unplugged drive) is kDisconnected; `recover`
/// continues with the next frame once it is back. Memory from the arena: two images and the image reader.
class KINETRACE_API FileStereoCamera final : public StereoCamera {
 public:
  [[nodiscard]] static std::size_t required_bytes(const Dataset& dataset, const FileCameraConfig& config);
  /// Errors: kInvalidConfig, kInvalidArgument (no complete pair in the dataset), kCapacity.
  [[nodiscard]] static Result<FileStereoCamera> create(Dataset dataset, const FileCameraConfig& config, Arena& arena);

  [[nodiscard]] Status open() override;
  [[nodiscard]] Status start() override;
  [[nodiscard]] Result<StereoFrame> next(std::chrono::milliseconds timeout) override;
  [[nodiscard]] Status stop() override;
  [[nodiscard]] Status recover() override;
  void close() noexcept override { state_ = CameraState::kClosed; }
  [[nodiscard]] std::string image_name(std::int64_t frame_index, bool is_left) const override;

  [[nodiscard]] CameraState state() const noexcept override { return state_; }
  [[nodiscard]] const CameraInfo& info() const noexcept override { return info_; }
  [[nodiscard]] const CameraCounters& counters() const noexcept override { return counters_; }

  [[nodiscard]] const Dataset& dataset() const noexcept { return dataset_; }
  /// Any frame of the recording by its index in the list, in any state, without advancing; for tools. Its images live
  /// until the next call of this or `next`. Errors: those of decoding it.
  [[nodiscard]] Result<StereoFrame> frame_at(std::size_t place);

  /// Why frames were skipped since start(): the first `max_warnings` messages, one line each.
  [[nodiscard]] const std::vector<std::string>& warnings() const noexcept { return warnings_; }

 private:
  struct Storage {
    std::array<MutableGrayView, 2> images;
    std::span<char> path;
  };
  explicit FileStereoCamera(Dataset dataset, const FileCameraConfig& config, imaging::ImageReader reader,
                            const Storage& storage);
  static void carve(const Dataset& dataset, Arena& arena, Storage& storage);
  [[nodiscard]] InPlaceStatus decode(std::size_t place);
  [[nodiscard]] const char* compose_path(const FrameFolder& folder, std::string_view stem);
  [[nodiscard]] StereoFrame deliver(const FrameList::Frame& frame);
  void advance();
  [[nodiscard]] Error end_of_recording() const;
  [[nodiscard]] bool folders_exist() const;
  void warn(std::string_view message);
  [[nodiscard]] Status require(bool allowed, const char* call) const;

  Dataset dataset_;
  FileCameraConfig config_;
  imaging::ImageReader reader_;
  Storage storage_;
  CameraInfo info_;
  CameraState state_ = CameraState::kClosed;
  CameraCounters counters_;
  std::vector<std::string> warnings_;
  std::string first_problem_;          ///< Why the first unreadable frame was skipped.
  std::int64_t pass_numbers_ = 0;      ///< Frame numbers that one pass spans.
  std::int64_t pass_duration_ns_ = 0;  ///< Time from the first frame of a pass to the first of the next.
  std::int64_t pass_ = 0;              ///< Completed passes.
  std::size_t position_ = 0;           ///< Next entry of the list.
};

}  // namespace kinetrace::hal
