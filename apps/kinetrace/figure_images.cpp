#include "figure_images.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

namespace kinetrace::figure {
namespace {

/// What run.json says about the recording.
struct RecordedAs {
  std::string dataset;
  std::string sequence;
  std::string cameras;
  hal::RectifierConfig rectification;
};

Result<RecordedAs> read_source(const std::filesystem::path& path) {
  const nlohmann::json run = nlohmann::json::parse(std::ifstream(path), nullptr, false);
  try {
    RecordedAs source;
    const nlohmann::json& dataset = run.at("dataset");
    source.dataset = dataset.at("dataset").get<std::string>();
    source.sequence = dataset.value("sequence", std::string());
    source.cameras = dataset.value("cameras", std::string());
    source.rectification.keep_borders =
        run.value("/config/rectification/keep_borders"_json_pointer, source.rectification.keep_borders);
    return source;
  } catch (const nlohmann::json::exception&) {
    return fail(ErrorCode::kBadFormat, path.string() + ": does not say which recording the run was made from");
  }
}

Result<hal::Dataset> open_recording(const RecordedAs& source) {
  const std::size_t colon = source.dataset.find(':');
  if (colon == std::string::npos || colon + 1 == source.dataset.size()) {
    return fail(ErrorCode::kInvalidArgument, "dataset " + source.dataset + ": expected LAYOUT:PATH");
  }
  const auto layout = hal::parse_layout(source.dataset.substr(0, colon));
  if (!layout) {
    return Unexpected(layout.error());
  }
  hal::DatasetSpec spec;
  spec.layout = *layout;
  spec.path = source.dataset.substr(colon + 1);
  if (source.cameras == "gray" || source.cameras == "color") {
    spec.cameras = source.cameras == "gray" ? hal::CameraChoice::kGray : hal::CameraChoice::kColor;
  }
  // The name of the sequence chooses among several; where there is one, not every layout knows it by that name.
  Result<hal::Dataset> alone = hal::open_dataset(spec);
  if (alone || alone.error().code != ErrorCode::kInvalidArgument || source.sequence.empty()) {
    return alone;
  }
  spec.sequence = source.sequence;
  return hal::open_dataset(spec);
}

struct Storage {
  std::optional<imaging::ImageReader> reader;
  MutableGrayView raw;
  std::optional<hal::Rectifier> rectifier;
};

Status take_storage(const hal::Dataset& dataset, const hal::RectifierConfig& rectification, Storage& storage,
                    std::unique_ptr<Arena>& arena) {
  const int width = dataset.calibration.raw_width_px();
  const int height = dataset.calibration.raw_height_px();
  imaging::ImageReaderConfig reading;
  reading.max_width_px = width;
  reading.max_height_px = height;
  constexpr std::size_t kSmallestBuffer = 4096;
  reading.max_file_bytes = std::max(dataset.max_file_bytes, kSmallestBuffer);
  constexpr std::size_t kRounding = 4 * Arena::kAlignment;
  const std::size_t image_bytes =
      measure_bytes([&](Arena& measured) { (void)take_image<std::uint8_t>(measured, width, height); });
  arena = std::make_unique<Arena>(imaging::ImageReader::required_bytes(reading) + image_bytes +
                                  hal::Rectifier::required_bytes(dataset.calibration, rectification) + kRounding);
  auto reader = imaging::ImageReader::create(reading, *arena);
  if (!reader) {
    return Unexpected(reader.error());
  }
  storage.raw = take_image<std::uint8_t>(*arena, width, height);
  auto rectifier = hal::Rectifier::create(dataset.calibration, rectification, *arena);
  if (!rectifier) {
    return Unexpected(rectifier.error());
  }
  storage.reader.emplace(std::move(*reader));
  storage.rectifier = *rectifier;
  return {};
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

RecordedImages::RecordedImages(hal::Dataset dataset, std::unique_ptr<Arena> arena, imaging::ImageReader reader,
                               MutableGrayView raw, hal::Rectifier rectifier)
    : dataset_(std::move(dataset)),
      arena_(std::move(arena)),
      reader_(std::move(reader)),
      raw_(raw),
      rectifier_(rectifier) {}

Result<RecordedImages> RecordedImages::open(const std::filesystem::path& run_directory, const std::string& moved_to) {
  Result<RecordedAs> recorded = read_source(run_directory / "run.json");
  if (!recorded) {
    return Unexpected(recorded.error());
  }
  if (!moved_to.empty()) {
    recorded->dataset = moved_to;
  }
  Result<hal::Dataset> dataset = open_recording(*recorded);
  if (!dataset) {
    return Unexpected(dataset.error());
  }
  Storage storage;
  std::unique_ptr<Arena> arena;
  if (const Status taken = take_storage(*dataset, recorded->rectification, storage, arena); !taken) {
    return Unexpected(taken.error());
  }
  return RecordedImages(std::move(*dataset), std::move(arena), std::move(*storage.reader), storage.raw,
                        *storage.rectifier);
}

std::string RecordedImages::stem(std::int64_t frame) const {
  const std::size_t place = find_frame(dataset_.frames, frame);
  return place == dataset_.frames.size() ? std::string() : std::string(dataset_.frames[place].left_stem);
}

Result<GrayView> RecordedImages::left(std::int64_t frame) {
  const std::string name = stem(frame);
  const hal::FrameFolder& folder = dataset_.frames.left();
  if (name.empty()) {
    return fail(ErrorCode::kNotFound, "the recording in " + folder.folder + " has no frame " + std::to_string(frame));
  }
  const std::string path = folder.folder + "/" + name + folder.suffix;
  if (const Status read = reader_.read_gray(path.c_str(), raw_); !read) {
    return Unexpected(read.error());
  }
  // The rectifier takes pairs; the right one is not used.
  const Result<RectifiedPair> pair = rectifier_.process({frame, 0, name, raw_, raw_});
  if (!pair) {
    return Unexpected(pair.error());
  }
  return pair->left;
}

}  // namespace kinetrace::figure
