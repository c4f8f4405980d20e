#include "kinetrace/hal/file_stereo_camera.hpp"

#include <algorithm>
#include <utility>

#include "dataset/image_files.hpp"
#include "formats/container_recording.hpp"
#include "util/image_folder.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Frame numbers and time that one pass spans.
struct PassSpan {
  std::int64_t numbers = 0;
  std::int64_t duration_ns = 0;
};

PassSpan pass_span(const Dataset& dataset) {
  const FrameList& frames = dataset.frames;
  const FrameList::Frame first = frames[0];
  const FrameList::Frame last = frames[frames.size() - 1];
  const std::int64_t period_ns = frames.median_period_ns(static_cast<std::int64_t>(1e9 / dataset.nominal_rate_hz));
  return {last.frame_index - first.frame_index + 1, last.timestamp_ns - first.timestamp_ns + period_ns};
}

Status check_passes(const Dataset& dataset, int passes) {
  const PassSpan span = pass_span(dataset);
  const FrameList::Frame last = dataset.frames[dataset.frames.size() - 1];
  const std::int64_t most = 1 + std::min((FrameList::kMaxFrameIndex - last.frame_index) / span.numbers,
                                         (FrameList::kMaxTime_ns - last.timestamp_ns) / span.duration_ns);
  if (passes > most) {
    return fail(ErrorCode::kInvalidConfig, concat(dataset.name, ": can be played ", std::to_string(most),
                                                  " times before its frame numbers or times become too large, not ",
                                                  std::to_string(passes), " times"));
  }
  return {};
}

}  // namespace

Status FileCameraConfig::validate() const {
  constexpr int kMaxPasses = 1'000'000;
  constexpr int kMaxWarnings = 1000;
  if (passes < 1 || passes > kMaxPasses) {
    return fail(ErrorCode::kInvalidConfig, "camera.passes must be in [1, 1000000], got " + std::to_string(passes));
  }
  if (max_warnings < 0 || max_warnings > kMaxWarnings) {
    return fail(ErrorCode::kInvalidConfig,
                "camera.max_warnings must be in [0, 1000], got " + std::to_string(max_warnings));
  }
  return {};
}

void FileStereoCamera::carve(const Dataset& dataset, Arena& arena, Storage& storage) {
  const RigCalibration& calibration = dataset.calibration;
  for (MutableGrayView& image : storage.images) {
    image = take_image<std::uint8_t>(arena, calibration.raw_width_px(), calibration.raw_height_px());
  }
  storage.path = arena.take<char>(dataset.frames.longest_path() + 1);
}

std::size_t FileStereoCamera::required_bytes(const Dataset& dataset, const FileCameraConfig& /*config*/) {
  return imaging::ImageReader::required_bytes(image_reader_config(dataset)) + measure_bytes([&dataset](Arena& arena) {
           Storage storage;
           carve(dataset, arena, storage);
         });
}

Result<FileStereoCamera> FileStereoCamera::create(Dataset dataset, const FileCameraConfig& config, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (dataset.frames.complete_count() == 0) {
    return fail(ErrorCode::kInvalidArgument, dataset.name + ": the dataset has no complete pair; check its folders");
  }
  auto reader = imaging::ImageReader::create(image_reader_config(dataset), arena);
  if (!reader) {
    return Unexpected(reader.error());
  }
  if (const Status fits = check_passes(dataset, config.passes); !fits) {
    return Unexpected(fits.error());
  }
  Storage storage;
  carve(dataset, arena, storage);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity,
                concat("the arena does not hold the camera's ", std::to_string(required_bytes(dataset, config)),
                       " bytes; enlarge the memory budget"));
  }
  return FileStereoCamera(std::move(dataset), config, std::move(*reader), storage);
}

FileStereoCamera::FileStereoCamera(Dataset dataset, const FileCameraConfig& config, imaging::ImageReader reader,
                                   const Storage& storage)
    : dataset_(std::move(dataset)), config_(config), reader_(std::move(reader)), storage_(storage) {
  const FrameList& frames = dataset_.frames;
  info_ = {.name = dataset_.name,
           .width_px = dataset_.calibration.raw_width_px(),
           .height_px = dataset_.calibration.raw_height_px(),
           .nominal_rate_hz = dataset_.nominal_rate_hz,
           .frame_count = static_cast<std::int64_t>(frames.size()) * config.passes};
  const PassSpan span = pass_span(dataset_);
  pass_numbers_ = span.numbers;
  pass_duration_ns_ = span.duration_ns;
  warnings_.reserve(static_cast<std::size_t>(config.max_warnings));
}

Status FileStereoCamera::require(bool allowed, const char* call) const {
  if (!allowed) {
    return fail(ErrorCode::kIllegalState, concat(info_.name, ": ", call, " is not allowed while the camera is ",
                                                 to_string(state_), "; see the states of StereoCamera"));
  }
  return {};
}

Status FileStereoCamera::open() {
  if (Status allowed = require(state_ == CameraState::kClosed, "open()"); !allowed) {
    return allowed;
  }
  if (!folders_exist()) {
    return fail(ErrorCode::kNotFound,
                dataset_.frames.left().folder + ": the recording's folder has gone; check the drive");
  }
  state_ = CameraState::kConfigured;
  return {};
}

Status FileStereoCamera::start() {
  if (Status allowed = require(state_ == CameraState::kConfigured, "start()"); !allowed) {
    return allowed;
  }
  counters_ = {};
  warnings_.clear();
  position_ = 0;
  pass_ = 0;
  state_ = CameraState::kStreaming;
  return {};
}

Status FileStereoCamera::stop() {
  const bool allowed =
      state_ == CameraState::kStreaming || state_ == CameraState::kStalled || state_ == CameraState::kRecovering;
  if (Status legal = require(allowed, "stop()"); !legal) {
    return legal;
  }
  state_ = CameraState::kConfigured;
  return {};
}

Status FileStereoCamera::recover() {
  if (Status allowed = require(state_ == CameraState::kLost, "recover()"); !allowed) {
    return allowed;
  }
  if (!folders_exist()) {
    return fail(ErrorCode::kDisconnected, dataset_.frames.left().folder + ": is still not there; put the drive back");
  }
  state_ = CameraState::kRecovering;
  return {};
}

Result<StereoFrame> FileStereoCamera::next(std::chrono::milliseconds /*timeout*/) {
  const bool allowed = state_ == CameraState::kStreaming || state_ == CameraState::kRecovering;
  if (const Status legal = require(allowed, "next()"); !legal) {
    return Unexpected(legal.error());
  }
  while (pass_ < config_.passes) {
    for (; position_ < dataset_.frames.size(); advance()) {
      const FrameList::Frame frame = dataset_.frames[position_];
      if (!frame.complete()) {
        ++counters_.skipped_missing_side;
        continue;
      }
      const InPlaceStatus decoded = decode(position_);
      if (decoded) {
        return deliver(frame);
      }
      if (!folders_exist()) {
        state_ = CameraState::kLost;
        return fail(ErrorCode::kDisconnected, dataset_.frames.left().folder +
                                                  ": the recording's folder has gone; put the drive back and recover");
      }
      ++counters_.skipped_unreadable;
      warn(decoded.error().message);
    }
    ++pass_;
    position_ = 0;
  }
  return Unexpected(end_of_recording());
}

StereoFrame FileStereoCamera::deliver(const FrameList::Frame& frame) {
  advance();
  ++counters_.frames_delivered;
  state_ = CameraState::kStreaming;
  return {frame.frame_index + pass_ * pass_numbers_, frame.timestamp_ns + pass_ * pass_duration_ns_, frame.name(),
          storage_.images[0], storage_.images[1]};
}

void FileStereoCamera::advance() {
  const std::size_t following = position_ + 1;
  if (following < dataset_.frames.size()) {
    const std::int64_t step = dataset_.frames[following].frame_index - dataset_.frames[position_].frame_index;
    counters_.gaps += static_cast<std::uint64_t>(step - 1);
  }
  position_ = following;
}

Error FileStereoCamera::end_of_recording() const {
  if (counters_.frames_delivered > 0) {
    return {ErrorCode::kEndOfStream, concat(info_.name, ": the recording has ended")};
  }
  return {ErrorCode::kBadFormat, concat(info_.name, ": none of its ", std::to_string(dataset_.frames.size()),
                                        " frames could be read; the first problem: ", first_problem_)};
}

std::string FileStereoCamera::image_name(std::int64_t frame_index, bool is_left) const {
  const FrameList& frames = dataset_.frames;
  const std::int64_t first = frames[0].frame_index;
  const std::int64_t index_of_pass = first + (frame_index - first) % pass_numbers_;
  for (std::size_t i = 0; !dataset_.container && i < frames.size(); ++i) {
    const FrameList::Frame frame = frames[i];
    if (frame.frame_index == index_of_pass && frame.complete()) {
      return is_left ? image_path(frames.left(), frame.left_stem) : image_path(frames.right(), frame.right_stem);
    }
  }
  return StereoCamera::image_name(frame_index, is_left);
}

Result<StereoFrame> FileStereoCamera::frame_at(std::size_t place) {
  const FrameList::Frame frame = dataset_.frames[place];
  if (const InPlaceStatus decoded = decode(place); !decoded) {
    return Unexpected(decoded.error());
  }
  return StereoFrame{frame.frame_index, frame.timestamp_ns, frame.name(), storage_.images[0], storage_.images[1]};
}

InPlaceStatus FileStereoCamera::decode(std::size_t place) {
  if (dataset_.container) {
    return dataset_.container->read(place, storage_.images[0], storage_.images[1]);
  }
  const FrameList::Frame frame = dataset_.frames[place];
  const InPlaceStatus left = reader_.read_gray(compose_path(dataset_.frames.left(), frame.left_stem),
                                               storage_.images[0], dataset_.sample_bits);
  return left ? reader_.read_gray(compose_path(dataset_.frames.right(), frame.right_stem), storage_.images[1],
                                  dataset_.sample_bits)
              : left;
}

const char* FileStereoCamera::compose_path(const FrameFolder& folder, std::string_view stem) {
  char* end = storage_.path.data();
  for (const std::string_view part :
       {std::string_view(folder.folder), std::string_view("/"), stem, std::string_view(folder.suffix)}) {
    end = std::copy(part.begin(), part.end(), end);
  }
  *end = '\0';
  return storage_.path.data();
}

bool FileStereoCamera::folders_exist() const {
  return is_folder(dataset_.frames.left().folder) && is_folder(dataset_.frames.right().folder);
}

void FileStereoCamera::warn(std::string_view message) {
  if (first_problem_.empty()) {
    first_problem_ = message;
  }
  if (warnings_.size() < static_cast<std::size_t>(config_.max_warnings)) {
    warnings_.emplace_back(message);
  }
}

}  // namespace kinetrace::hal
