#include "figure/figure_images.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "figure/same_recording.hpp"

namespace kinetrace::figure {
namespace {

Result<hal::Dataset> open_recording(const recording::Run& run, const std::string& dataset) {
  const std::size_t colon = dataset.find(':');
  if (colon == std::string::npos || colon + 1 == dataset.size()) {
    return fail(ErrorCode::kInvalidArgument, "dataset " + dataset + ": expected LAYOUT:PATH");
  }
  const auto layout = hal::parse_layout(dataset.substr(0, colon));
  if (!layout) {
    return Unexpected(layout.error());
  }
  hal::DatasetSpec spec;
  spec.layout = *layout;
  spec.path = dataset.substr(colon + 1);
  if (run.cameras == "gray" || run.cameras == "color") {
    spec.cameras = run.cameras == "gray" ? hal::CameraChoice::kGray : hal::CameraChoice::kColor;
  }
  // The sequence's name selects among several; with only one, some layouts do not accept the name.
  Result<hal::Dataset> alone = hal::open_dataset(spec);
  if (alone || alone.error().code != ErrorCode::kInvalidArgument || run.sequence.empty()) {
    return alone;
  }
  spec.sequence = run.sequence;
  return hal::open_dataset(spec);
}

/// Rectification of the run's configuration.
hal::RectifierConfig rectification_of(const recording::Run& run) {
  hal::RectifierConfig rectification;
  const nlohmann::json config = nlohmann::json::parse(run.config_json, nullptr, false);
  const nlohmann::json::json_pointer key("/rectification/keep_borders");
  if (config.is_object() && config.contains(key) && config.at(key).is_number()) {
    rectification.keep_borders = config.at(key).get<double>();
  }
  return rectification;
}

/// Place of a frame in the list, or its size.
std::size_t find_frame(const hal::FrameList& frames, std::int64_t number) {
  std::size_t low = 0;
  std::size_t high = frames.size();
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (frames[middle].frame_index < number) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < frames.size() && frames[low].frame_index == number ? low : frames.size();
}

}  // namespace

RecordedImages::RecordedImages(std::unique_ptr<Arena> arena, hal::FileStereoCamera camera, hal::Rectifier rectifier,
                               std::int64_t passes)
    : arena_(std::move(arena)), camera_(std::move(camera)), rectifier_(rectifier), passes_(passes) {}

Result<RecordedImages> RecordedImages::open(const recording::Run& run, const std::string& moved_to) {
  if (run.dataset.empty() && moved_to.empty()) {
    return fail(ErrorCode::kBadFormat, run.directory.string() + ": does not say which recording the run was made from");
  }
  const std::string& name = moved_to.empty() ? run.dataset : moved_to;
  Result<hal::Dataset> dataset = open_recording(run, name);
  if (!dataset) {
    return Unexpected(dataset.error());
  }
  const hal::RectifierConfig rectification = rectification_of(run);
  auto arena = std::make_unique<Arena>(hal::FileStereoCamera::required_bytes(*dataset, {}) +
                                       hal::Rectifier::required_bytes(dataset->calibration, rectification) +
                                       2 * Arena::kAlignment);
  auto rectifier = hal::Rectifier::create(dataset->calibration, rectification, *arena);
  if (!rectifier) {
    return Unexpected(rectifier.error());
  }
  auto camera = hal::FileStereoCamera::create(std::move(*dataset), {}, *arena);
  if (!camera) {
    return Unexpected(camera.error());
  }
  RecordedImages images(std::move(arena), std::move(*camera), *rectifier, run.passes);
  if (const Status same = check_same_recording(run, name, images); !same) {
    return Unexpected(same.error());
  }
  return images;
}

// Frame numbers of a further pass continue after the recording's last.
RecordedImages::Found RecordedImages::find(std::int64_t frame) const {
  const std::int64_t first = frames()[0].frame_index;
  const std::int64_t numbers = frames()[frames().size() - 1].frame_index - first + 1;
  const std::int64_t pass = std::clamp<std::int64_t>((frame - first) / numbers, 0, passes_ - 1);
  return {find_frame(frames(), frame - pass * numbers), pass};
}

std::string RecordedImages::stem(std::int64_t frame) const {
  const auto [place, pass] = find(frame);
  if (place == frames().size()) {
    return {};
  }
  const std::string stem(frames()[place].left_stem);
  return pass == 0 ? stem : stem + "_pass" + std::to_string(pass + 1);
}

Result<RectifiedPair> RecordedImages::pair(std::int64_t frame) {
  const std::size_t place = find(frame).place;
  if (place == frames().size() || !frames()[place].complete()) {
    return fail(ErrorCode::kNotFound, "the recording in " + frames().left().folder + " has no frame " +
                                          std::to_string(frame) + " with the images of both views");
  }
  const Result<StereoFrame> raw = camera_.frame_at(place);
  if (!raw) {
    return Unexpected(raw.error());
  }
  return rectifier_.process(*raw);
}

Result<GrayView> RecordedImages::left(std::int64_t frame) {
  const Result<RectifiedPair> both = pair(frame);
  if (!both) {
    return Unexpected(both.error());
  }
  return both->left;
}

}  // namespace kinetrace::figure
